// Pictures that give materials their albedo, as they are looked up.
#pragma once

#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/mesh_import.h"
#include "transport/vector_types.h"

namespace bakelight::simplify {

// The picture as linear R, G, B within 0–1: formats of 8 and 16 bits hold display codes (sRGB), EXR and
// Radiance are linear. Alpha is not looked at. Values outside are clamped, and `notes` told. Throws
// Error(kBadInput) naming the texture, and `mesh_file` where that leads to it: missing, no picture, neither
// R, G, B nor a single channel.
formats::Image readAlbedoTexture(const formats::AlbedoTexture& texture, const std::string& mesh_file,
                                 std::vector<std::string>& notes);

class AlbedoMap {
 public:
  using Wrap = formats::AlbedoTexture::Wrap;

  // `image` has three channels.
  AlbedoMap(formats::Image image, Wrap wrap_u, Wrap wrap_v);

  // u right, v up, origin at the lower left. Bilinear, between the texels of the halving whose size is that
  // of `area`, in units of the whole picture's.
  transport::Vec3 colorAt(double u, double v, double area) const;

 private:
  std::vector<formats::Image> levels_;  // the picture and its halvings
  Wrap wrap_u_, wrap_v_;
};

}  // namespace bakelight::simplify
