#include "tools/player/techniques/vertex_radiance.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"
#include "tools/player/operators/visibility_operator.h"
#include "transport/sh.h"
#include "transport/vertex_shading.h"

namespace bakelight::player {
namespace {

bool hasReflection(const formats::Pack& pack) {
  return pack.sh().glossy &&
         std::any_of(pack.appearances.begin(), pack.appearances.end(),
                     [](const formats::Appearance& appearance) {
                       return appearance.reflection.as<formats::LambertReflection>() == nullptr;
                     });
}

bool hasTable(const formats::Pack& pack) {
  return std::any_of(pack.appearances.begin(), pack.appearances.end(),
                     [](const formats::Appearance& appearance) {
                       return appearance.reflection.as<formats::BrdfTable>() != nullptr;
                     });
}

// Base colours of the appearances, times the vertices' own.
std::vector<formats::Float3> vertexAlbedos(const formats::Pack& pack) {
  std::vector<formats::Float3> albedos = pack.colors;
  albedos.resize(pack.mesh.vertexCount(), {1, 1, 1});
  const std::vector<formats::VertexRange> ranges = formats::appearanceRanges(pack);
  for (std::size_t i = 0; i < ranges.size(); ++i)
    for (std::size_t v = ranges[i].first; v < ranges[i].end; ++v)
      for (std::size_t c = 0; c < 3; ++c) albedos[v][c] *= pack.appearances[i].base_color[c];
  return albedos;
}

}  // namespace

bool VertexRadiance::plays(const formats::Pack& pack) {
  return transport::VertexShading::shades(pack);
}

transport::LightNeeds VertexRadiance::needs(const formats::Pack& pack) {
  const formats::ShTransfer& transfer = pack.sh();
  transport::LightNeeds needs{transfer.order};
  if (transfer.near_field) needs.near_center = transport::vec3(transfer.near_field->center);
  return needs;
}

VertexRadiance::VertexRadiance(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light)
    : vectors_(pack.sh().vectors) {
  const formats::ShTransfer& transfer = pack.sh();
  const std::size_t count = pack.mesh.vertexCount();
  if (vectors_.rows() != count || (!pack.colors.empty() && pack.colors.size() != count))
    throw std::invalid_argument("transfer table and vertex count do not fit together");

  const bool one_material = pack.appearances.size() == 1;
  Albedo albedo;
  if (one_material) albedo.base_color = pack.appearances.front().base_color;
  if (!one_material || !pack.colors.empty()) {
    const std::vector<formats::Float3> colors = one_material ? pack.colors : vertexAlbedos(pack);
    vertex_colors_ = makeBuffer(count * sizeof(formats::Float3), colors.data());
    albedo.vertex_colors = &vertex_colors_;
  }
  distant_.emplace(vectors_, transfer.order, transfer.channels, albedo, false);
  if (near_light) {
    if (transfer.near_field) near_vectors_ = GpuTable(transfer.near_field->vectors);
    near_.emplace(near_vectors_.empty() ? vectors_ : near_vectors_, transfer.order, transfer.channels, albedo,
                  true);
  }
  if (hasReflection(pack)) {
    if (transfer.glossy->vertexTable().rows != count)
      throw std::invalid_argument("transfer matrices and vertex count do not fit together");
    const bool object_frame = transfer.glossy->isInObjectFrame();
    const bool expand = object_frame && hasTable(pack);
    transfer_ = makeTransferOperator(expand ? matricesFromVisibility(pack) : transfer);
    glossy_.emplace(pack, mesh, object_frame && !expand);
    total_light_.emplace(near_light);
  }
  surface_.emplace(mesh.positions(), radiance(), mesh.indices(), mesh.indexCount());
}

void VertexRadiance::setLight(const GpuLight& distant, const GpuLight* near) {
  if (near_ && near == nullptr) throw std::invalid_argument("near light is missing");
  const std::uint64_t near_revision = near_ ? near->revision : kNone;
  const bool distant_has_changed = distant.revision != distant_revision_;
  if (!distant_has_changed && near_revision == near_revision_) return;
  evaluateDiffuse(distant, near, distant_has_changed);
  if (transfer_) transfer(distant, near);
  distant_revision_ = distant.revision;
  near_revision_ = near_revision;
}

void VertexRadiance::evaluateDiffuse(const GpuLight& distant, const GpuLight* near,
                                     bool distant_has_changed) {
  const GpuPass pass("diffuse");
  if (distant_has_changed) distant_->evaluate(distant.sh);
  if (near_) near_->evaluate(near->sh, &distant_->buffer());
}

void VertexRadiance::transfer(const GpuLight& distant, const GpuLight* near) {
  const GpuPass pass("transfer");
  if (!total_light_->update(distant, near)) return;
  transfer_->evaluate(total_light_->sh());
  throwIfGlFailed("transferring the light");
}

void VertexRadiance::lookFrom(const transport::ViewPoint& view) {
  if (!glossy_) return;
  const GpuPass pass("glossy");
  glossy_->evaluate(view.eye, transfer_->transferred(), (near_ ? *near_ : *distant_).buffer());
}

void VertexRadiance::draw(const Eigen::Matrix4f& clip_from_position) const {
  const GpuPass pass("surface");
  surface_->draw(clip_from_position);
}

const Buffer& VertexRadiance::radiance() const {
  return glossy_ ? glossy_->buffer() : (near_ ? *near_ : *distant_).buffer();
}

std::size_t VertexRadiance::gpuBytes() const {
  std::size_t bytes = vectors_.gpuBytes() + near_vectors_.gpuBytes() + sizeInBytes(vertex_colors_) +
                      sizeInBytes(distant_->buffer());
  if (near_) bytes += sizeInBytes(near_->buffer());
  if (total_light_) bytes += total_light_->gpuBytes();
  if (transfer_) bytes += transfer_->gpuBytes();
  if (glossy_) bytes += glossy_->gpuBytes();
  return bytes;
}

}  // namespace bakelight::player
