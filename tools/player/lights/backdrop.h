// The distant light as it is seen behind the object.
#pragma once

#include <cstddef>
#include <Eigen/Core>

#include "formats/image.h"
#include "tools/player/gl/gl_objects.h"
#include "transport/camera.h"

namespace bakelight::player {

class Backdrop {
 public:
  // `image`: lat-long, R, G, B. Throws Error(kBadInput) if it is larger than this GL's textures.
  explicit Backdrop(const formats::Image& image);

  // Fills what is still at the far plane of the framebuffer that is bound, of that size in subsamples.
  void draw(const transport::OrbitCamera& camera, const Eigen::Matrix3d& world_from_light, int width,
            int height) const;
  std::size_t gpuBytes() const { return bytes_; }

 private:
  Program program_;
  VertexArray no_attributes_;
  Texture image_;
  std::size_t bytes_;
};

}  // namespace bakelight::player
