// Translucent objects: a texture of radiosity below the surface, drawn by Fresnel's share towards the eye. The texture is made
// anew when light changes (TexelResponse); transport::TranslucentShading is the same on the CPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "tools/player/gl/gl_objects.h"
#include "tools/player/operators/diffuse_pass.h"
#include "tools/player/techniques/technique.h"
#include "tools/player/techniques/texel_light.h"
#include "tools/player/techniques/texel_response.h"

namespace bakelight::player {

class Translucent final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  Translucent(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light);

  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void setPunctualLights(std::span<const transport::PlacedPunctualLight> lights) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  double eta_;
  transport::Vec3 origin_, eye_ = transport::Vec3::Zero();
  std::uint64_t distant_revision_ = kNone, near_revision_ = kNone;  // evaluated
  Buffer normals_, texcoords_, stain_;
  GpuTable vectors_, near_vectors_;
  DiffusePass distant_;
  std::optional<DiffusePass> near_;
  TexelLight texel_light_;
  bool has_punctual_ = false, punctual_is_new_ = false;
  Buffer punctual_;  // what enters of punctual lights: RGB a texel
  TexelResponse response_;
  Program program_;
  VertexArray vertices_;
  GLsizei index_count_;
};

}  // namespace bakelight::player
