// All-frequency bi-scale shading: transfer in a pixel basis from a cube map of light to the cells of the hemisphere over each
// vertex, BTFs at the pixels. transport::AllFrequencyShading does the same on the CPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "formats/pack_contents.h"
#include "formats/pixel_transfer.h"
#include "tools/player/techniques/patch_projection.h"
#include "tools/player/techniques/patch_surface.h"
#include "tools/player/techniques/pixel_product.h"
#include "tools/player/techniques/technique.h"

namespace bakelight::player {

class AllFrequency final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  AllFrequency(const formats::Pack& pack, const SurfaceMesh& mesh);

  // Throws std::logic_error: its light is a cube map.
  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void setCubeLight(std::span<const formats::Float3> radiance) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

 private:
  void transfer();

  int cube_side_, subsamples_;
  std::size_t cells_;
  std::unique_ptr<PixelProduct> product_;
  Buffer light_;     // texels × RGB: radiance × solid angle ÷ subsamples²
  Buffer incident_;  // blocks × cells × RGB
  std::unique_ptr<PatchSurface> surface_;
  std::unique_ptr<PatchProjection> projection_;
};

}  // namespace bakelight::player
