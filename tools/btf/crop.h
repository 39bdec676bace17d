// A part of a BTF's texels, several averaged to one.
#pragma once

#include <memory>

#include "formats/btf.h"

namespace bakelight::btf {

struct Crop {
  int left = 0, top = 0, width = 0, height = 0;  // texels; width or height 0: to the end
  int shrink = 1;                                // so many texels a side become one, their mean
};

// Throws Error(kBadInput) naming the BTF if nothing is left. Columns and rows at the right and the bottom that do not fill
// a texel are left out: as many as `dropped` says.
std::shared_ptr<const formats::Btf> cropped(std::shared_ptr<const formats::Btf> btf, const Crop& crop,
                                            int* dropped = nullptr);

}  // namespace bakelight::btf
