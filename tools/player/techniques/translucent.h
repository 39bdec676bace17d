// Translucent objects: a texture of radiosity below the surface, drawn by Fresnel's share towards the eye. The texture is made on the CPU
// when light changes (transport::TranslucentShading).
#pragma once

#include <cstddef>
#include <cstdint>

#include "tools/player/gl/gl_objects.h"
#include "tools/player/techniques/technique.h"
#include "transport/translucent_shading.h"

namespace bakelight::player {

class Translucent final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  Translucent(const formats::Pack& pack, const SurfaceMesh& mesh);

  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  transport::TranslucentShading shading_;
  transport::Vec3 origin_, eye_ = transport::Vec3::Zero();
  std::uint64_t distant_revision_ = kNone, near_revision_ = kNone;  // evaluated
  Buffer normals_, texcoords_, stain_;
  Texture radiosity_;
  Program program_;
  VertexArray vertices_;
  GLsizei index_count_;
};

}  // namespace bakelight::player
