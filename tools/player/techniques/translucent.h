// Translucent objects: a texture of radiosity below the surface, drawn by Fresnel's share towards the eye. The texture is made on the CPU
// when light changes (transport::TranslucentShading).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "tools/player/gl/gl_objects.h"
#include "tools/player/techniques/technique.h"
#include "tools/player/techniques/texel_light.h"
#include "transport/translucent_shading.h"

namespace bakelight::player {

class Translucent final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  Translucent(const formats::Pack& pack, const SurfaceMesh& mesh);

  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void setPunctualLights(std::span<const transport::PlacedPunctualLight> lights) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  void takePunctualLight();

  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  transport::TranslucentShading shading_;
  transport::Vec3 origin_, eye_ = transport::Vec3::Zero();
  std::uint64_t distant_revision_ = kNone, near_revision_ = kNone;  // evaluated
  Buffer normals_, texcoords_, stain_;
  TexelLight texel_light_;
  bool has_punctual_ = false, punctual_is_new_ = false;
  Buffer punctual_;  // what enters of punctual lights: RGB a texel
  Texture radiosity_;
  Program program_;
  VertexArray vertices_;
  GLsizei index_count_;
};

}  // namespace bakelight::player
