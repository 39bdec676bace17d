// The technique in the player.
#pragma once

#include "tools/player/techniques/technique.h"

namespace bakelight::example {

// What NormalShading is on the CPU, in a fragment shader.
class NormalTechnique final : public player::Technique {
 public:
  NormalTechnique(const formats::Pack& pack, const player::SurfaceMesh& mesh, bool near_light);

  void setLight(const player::GpuLight& distant, const player::GpuLight* near) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  const player::SurfaceMesh& mesh_;
  player::Buffer normals_;
  player::Texture picture_;
  std::size_t picture_bytes_ = 0;
  player::Program program_;
  player::VertexArray vertices_;
  const player::GpuLight* distant_ = nullptr;
  const player::GpuLight* near_ = nullptr;
  transport::Float3 eye_ = {0, 0, 0};  // from the mesh's origin
};

player::PlayedTechnique normalTechnique();

}  // namespace bakelight::example
