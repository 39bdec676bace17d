// Bi-scale shading (Sloan, Liu, Shum & Snyder 2003): transferred radiance at the vertices, radiance transfer textures at the
// pixels. transport::BiScaleShading does the same on the CPU.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/lights/total_light.h"
#include "tools/player/operators/transfer_operator.h"
#include "tools/player/techniques/patch_projection.h"
#include "tools/player/techniques/patch_surface.h"
#include "tools/player/techniques/technique.h"

namespace bakelight::player {

class BiScale final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  BiScale(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light);

  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  int output_order_;
  std::unique_ptr<TransferOperator> transfer_;
  TotalLight light_;
  std::unique_ptr<PatchSurface> surface_;
  std::unique_ptr<PatchProjection> projection_;
};

}  // namespace bakelight::player
