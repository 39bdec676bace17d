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

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

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
  albedo_ = bufferOf(albedos(pack, ranges));
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto& reflection = static_cast<const RttReflection&>(*patches[i].patch);
    const auto coefficients = static_cast<std::size_t>(transport::coefficientCount(reflection.order));
    const std::size_t groups = surface_->groupsAtOnce(i);
    Projection projection;
    projection.vertices = ranges[i];
    projection.program = makeComputeProgram({kPatchProjectComp}, "#define GROUPS " + std::to_string(groups) +
                                                                     "\n#define INCIDENT " +
                                                                     std::to_string(coefficients) + "u\n");
    for (std::size_t draw = 0; draw < surface_->drawCount(i); ++draw)
      projection.bases.push_back(
          bufferOf(PatchSurface::basisOf(reflection, coefficients, draw * groups, groups)));
    projections_.push_back(std::move(projection));
  }
  throwIfGlFailed("uploading radiance transfer textures");
}

void BiScale::setLight(const GpuLight& distant, const GpuLight* near) {
  if (!light_.update(distant, near)) return;
  {
    const GpuPass pass("transfer");
    transfer_->evaluate(light_.sh());
    throwIfGlFailed("transferring the light");
  }
  project();
}

void BiScale::project() {
  const GpuPass pass("project");
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  const std::size_t transferred_bytes =
      static_cast<std::size_t>(transport::coefficientCount(output_order_)) * sizeof(Float3);
  const std::size_t projected_bytes = surface_->mostGroups() * 3 * sizeof(Float4);
  const std::vector<RowRange> ranges =
      rowRanges(sizeInBytes(albedo_) / sizeof(Float3), std::max(transferred_bytes, projected_bytes), 1);
  for (std::size_t p = 0; p < projections_.size(); ++p) {
    const Projection& patch = projections_[p];
    glUseProgram(patch.program.name());
    glUniform1ui(3, static_cast<GLuint>(surface_->mostGroups()));
    glUniform1ui(4, static_cast<GLuint>(transport::coefficientCount(output_order_)));
    for (const RowRange& range : ranges) {
      const std::size_t first = std::max(range.first, patch.vertices.first);
      const std::size_t end = std::min(range.first + range.count, patch.vertices.end);
      if (first >= end) continue;
      bindRows(0, transfer_->transferred(), range, transferred_bytes);
      bindRows(2, albedo_, range, sizeof(Float3));
      bindRows(3, surface_->projected(), range, projected_bytes);
      glUniform1ui(0, static_cast<GLuint>(end - range.first));
      glUniform1ui(1, static_cast<GLuint>(first - range.first));
      for (std::size_t i = 0; i < patch.bases.size(); ++i) {
        glUniform1ui(2, static_cast<GLuint>(i * surface_->groupsAtOnce(p)));
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, patch.bases[i].name());
        dispatchItems(end - first);
      }
    }
  }
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("projecting onto radiance transfer textures");
}

void BiScale::lookFrom(const transport::ViewPoint& view) {
  surface_->lookFrom(view);
}

void BiScale::draw(const Eigen::Matrix4f& clip_from_position) const {
  surface_->draw(clip_from_position);
}

std::size_t BiScale::gpuBytes() const {
  return transfer_->gpuBytes() + light_.gpuBytes() + surface_->gpuBytes() + sizeInBytes(albedo_);
}

}  // namespace bakelight::player
