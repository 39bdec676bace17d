// Colours of vertices and faces as mesh files have them. Private to the importers.
#pragma once

#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// sRGB (IEC 61966-2-1) to linear. Values outside 0–1 stay outside.
float linearFromSrgb(float srgb);
Float3 linearFromSrgb(const Float3& srgb);

// What the numbers of a file's colours are, judged by all of them.
class ColorRange {
 public:
  void add(const Float3& color);
  // Whether some are far beyond 1 and none is beyond 255, so that 255 is white.
  bool isOfBytes() const { return largest_ > 2 && largest_ <= 255; }
  bool areWhole() const { return whole_; }  // whether all are integers
  float largest() const { return largest_; }

 private:
  float largest_ = 0;
  bool whole_ = true;
};

}  // namespace bakelight::formats
