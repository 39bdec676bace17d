// ꟻLIP: how different two pictures look to a person who flips between them. Andersson, Nilsson,
// Akenine-Möller, Oskarsson, Åström & Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images"
// (LDR-FLIP, with its authors' constants).
#pragma once

#include <vector>

#include "formats/image.h"

namespace bakelight::report {

// A display of 3840 pixels across 0.7 m, seen from 0.7 m: about 67.
double defaultPixelsPerDegree();

class FlipReference {
 public:
  // `reference` has the channels R, G, B first, display-encoded (sRGB) in [0, 1]; further ones are left out.
  // Throws std::invalid_argument for fewer channels.
  explicit FlipReference(const formats::Image& reference,
                         double pixels_per_degree = defaultPixelsPerDegree());

  // The error of each pixel, rows from top to bottom: 0 equal, 1 as different as can be. Throws
  // std::invalid_argument for another size. Cost: separable filters of about 20 taps, ten passes; on all TBB
  // threads, the same bytes whatever their number.
  std::vector<float> errorsOf(const formats::Image& test) const;

  // Of one picture: colours as the eye resolves them, and how strong edges and points are.
  struct Perceived {
    std::vector<float> color;          // L*, a*, b* a pixel, after Hunt's adjustment
    std::vector<float> edges, points;  // 0 – about 1
  };

 private:
  int width_, height_;
  double pixels_per_degree_;
  Perceived reference_;
};

}  // namespace bakelight::report
