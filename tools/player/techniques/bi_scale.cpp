#include "tools/player/techniques/bi_scale.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/gpu_timer.h"
#include "tools/player/operators/visibility_operator.h"
#include "transport/bi_scale_shading.h"
#include "transport/sh.h"

namespace bakelight::player {
namespace {

using formats::Float3;
using formats::Float4;
using formats::RttReflection;

std::vector<Float3> albedos(const formats::Pack& pack, const std::vector<formats::VertexRange>& ranges) {
  std::vector<Float3> albedo(pack.mesh.vertexCount(), Float3{1, 1, 1});
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (pack.appearances[i].reflection.as<RttReflection>() != nullptr) continue;
    for (std::size_t v = ranges[i].first; v < ranges[i].end; ++v)
      for (std::size_t c = 0; c < 3; ++c)
        albedo[v][c] = pack.appearances[i].base_color[c] * (pack.colors.empty() ? 1 : pack.colors[v][c]);
  }
  return albedo;
}

}  // namespace

bool BiScale::plays(const formats::Pack& pack) {
  return transport::BiScaleShading::shades(pack);
}

transport::LightNeeds BiScale::needs(const formats::Pack& pack) {
  return {pack.sh().order};
}

BiScale::BiScale(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light)
    : output_order_(pack.sh().glossy.value().output_order), light_(near_light) {
  const formats::GlossyTransfer& transfer = *pack.sh().glossy;
  transfer_ = makeTransferOperator(transfer.isInObjectFrame() ? matricesFromVisibility(pack) : pack.sh());
  const std::vector<formats::VertexRange> ranges = formats::appearanceRanges(pack);
  const std::vector<const formats::PackImage*> indices = formats::patchIndices(pack);
  const RttReflection flat = transport::flatReflection(output_order_);
  std::vector<SurfacePatch> patches;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto* own = pack.appearances[i].reflection.as<RttReflection>();
    const RttReflection& reflection = own == nullptr ? flat : *own;
    if (reflection.order > output_order_)
      throw std::invalid_argument("a radiance transfer texture has more bands than the transferred radiance");
    patches.push_back({&reflection, own == nullptr ? nullptr : indices[i]});
  }
  surface_ = std::make_unique<PatchSurface>(pack.mesh, transfer.tangents, patches, mesh.origin());
  std::vector<ProjectedPatch> projected;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto& reflection = static_cast<const RttReflection&>(*patches[i].patch);
    projected.push_back(
        {&reflection, ranges[i], static_cast<std::size_t>(transport::coefficientCount(reflection.order))});
  }
  projection_ =
      std::make_unique<PatchProjection>(*surface_, projected, albedos(pack, ranges),
                                        static_cast<std::size_t>(transport::coefficientCount(output_order_)));
  throwIfGlFailed("uploading radiance transfer textures");
}

void BiScale::setLight(const GpuLight& distant, const GpuLight* near) {
  if (!light_.update(distant, near)) return;
  {
    const GpuPass pass("transfer");
    transfer_->evaluate(light_.sh());
    throwIfGlFailed("transferring the light");
  }
  projection_->run(transfer_->transferred());
}

void BiScale::lookFrom(const transport::ViewPoint& view) {
  surface_->lookFrom(view);
}

void BiScale::draw(const Eigen::Matrix4f& clip_from_position) const {
  surface_->draw(clip_from_position);
}

std::size_t BiScale::gpuBytes() const {
  return transfer_->gpuBytes() + light_.gpuBytes() + surface_->gpuBytes() + projection_->gpuBytes();
}

}  // namespace bakelight::player
