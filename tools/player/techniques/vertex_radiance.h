// Exit radiance at the vertices, interpolated between them: SH transfer under Lambert, lobes or BRDF tables
// (Sloan et al. 2002, 2003; near light: Fujita & Kanai 2004). Which passes a pack and its lights need, and
// when they run. transport::VertexShading does the same on the CPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "formats/pack_contents.h"
#include "tools/player/lights/total_light.h"
#include "tools/player/operators/diffuse_pass.h"
#include "tools/player/operators/transfer_operator.h"
#include "tools/player/techniques/glossy_pass.h"
#include "tools/player/techniques/technique.h"

namespace bakelight::player {

class VertexRadiance final : public Technique {
 public:
  static bool plays(const formats::Pack& pack);
  static transport::LightNeeds needs(const formats::Pack& pack);

  // Uploads the tables that are played. Without `near_light` tables and buffers of near light are left out,
  // as those of glossiness are for a diffuse pack.
  VertexRadiance(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light);

  void setLight(const GpuLight& distant, const GpuLight* near) override;
  void lookFrom(const transport::ViewPoint& view) override;
  void draw(const Eigen::Matrix4f& clip_from_position) const override;
  std::size_t gpuBytes() const override;

  // n × RGB float32: the same buffer for the whole life.
  const Buffer& radiance() const;

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  void evaluateDiffuse(const GpuLight& distant, const GpuLight* near, bool distant_has_changed);
  void transfer(const GpuLight& distant, const GpuLight* near);

  GpuTable vectors_, near_vectors_;
  Buffer vertex_colors_;
  std::uint64_t distant_revision_ = kNone, near_revision_ = kNone;  // evaluated
  std::optional<DiffusePass> distant_, near_;
  std::unique_ptr<TransferOperator> transfer_;
  std::optional<TotalLight> total_light_;  // of a glossy pack
  std::optional<GlossyPass> glossy_;
  std::optional<RadiantSurface> surface_;
};

}  // namespace bakelight::player
