// Punctual lights on the texels of a translucent object (transport::TexelIrradiance on the GPU): each light draws what it sees of the
// object, then each texel asks whether that is itself.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/surface_mesh.h"
#include "transport/punctual_light.h"
#include "transport/texel_irradiance.h"

namespace bakelight::player {

class TexelLight {
 public:
  // Edges of what a light sees, in texels: of one view around an object that it looks at from outside, or of each face of a cube.
  static constexpr int kSide = 2048, kCubeSide = 1024;

  // `normals`: a vertex, as of the mesh. The pack may go; `mesh` and `normals` outlive this.
  TexelLight(const formats::Pack& pack, const SurfaceMesh& mesh, const Buffer& normals);

  // Adds irradiance × Schlick's transmittance of all lights to `entering`: RGB float32 a texel, in the order of
  // Translucency::texels. Shadows have edges of ± one of a light's texels. Leaves the framebuffer bound and depth test as its own.
  void add(std::span<const transport::PlacedPunctualLight> lights, const Buffer& entering);

  std::size_t texelCount() const { return texel_count_; }
  std::size_t gpuBytes() const;

 private:
  struct Views {
    Texture depths, hidden;  // layers; of the depth test
    std::vector<Framebuffer> framebuffers;
    int side = 0;
  };
  struct Eyes {
    std::vector<Eigen::Matrix3f> axes;  // to the right, up, forward
    float tangent;
  };
  Views makeViews(int side, int count) const;
  Eyes eyesOf(const transport::PlacedPunctualLight& light) const;
  void look(const transport::PlacedPunctualLight& light, const Eyes& eyes, const Views& views) const;
  void light(const transport::PlacedPunctualLight& light, const Eyes& eyes, const Views& views,
             const Buffer& entering);
  const Texture& slideOf(const std::shared_ptr<const formats::Image>& image);

  const SurfaceMesh& mesh_;
  const Buffer& normals_;
  transport::BoundingSphere bounds_;
  std::size_t texel_count_;
  float normal_reflectance_, offset_;
  Buffer texels_, triangles_;
  Program depth_program_, light_program_;
  VertexArray vertices_;
  Views single_, cube_;  // made when needed first
  struct Slide {
    std::shared_ptr<const formats::Image> image;
    Texture texture;
  };
  std::map<const formats::Image*, Slide> slides_;
};

}  // namespace bakelight::player
