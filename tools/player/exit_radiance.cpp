#include "tools/player/exit_radiance.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "tools/player/gl_program.h"
#include "tools/player/gpu_light.h"
#include "transport/sh.h"

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

ExitRadiance::ExitRadiance(const formats::Pack& pack, const transport::Vec3& origin, const Buffer* near_light)
    : order_(pack.sh().order),
      vectors_(pack.sh().vectors),
      distant_light_(makeLightBuffer()),
      near_light_(near_light) {
  const formats::ShTransfer& transfer = pack.sh();
  const std::size_t count = pack.mesh.vertexCount();
  if (vectors_.rows() != count || (!pack.colors.empty() && pack.colors.size() != count))
    throw std::invalid_argument("transfer table and vertex count do not fit together");

  Albedo albedo{pack.appearances.front().base_color, nullptr};
  if (pack.appearances.size() > 1) {
    vertex_colors_ = makeBuffer(count * sizeof(formats::Float3), vertexAlbedos(pack).data());
    albedo = {{1, 1, 1}, &vertex_colors_};
  } else if (!pack.colors.empty()) {
    vertex_colors_ = makeBuffer(count * sizeof(formats::Float3), pack.colors.data());
    albedo.vertex_colors = &vertex_colors_;
  }
  distant_.emplace(vectors_, transfer.order, transfer.channels, albedo, false);
  if (near_light_ != nullptr) {
    if (transfer.near_field) near_vectors_ = GpuTable(transfer.near_field->vectors);
    near_.emplace(near_vectors_.empty() ? vectors_ : near_vectors_, transfer.order, transfer.channels, albedo,
                  true);
  }
  if (!hasReflection(pack)) return;
  if (transfer.glossy->vertexTable().rows != count)
    throw std::invalid_argument("transfer matrices and vertex count do not fit together");
  const bool object_frame = transfer.glossy->isInObjectFrame();
  const bool expand = object_frame && hasTable(pack);
  transfer_.emplace(expand ? matricesFromVisibility(pack) : transfer);
  glossy_.emplace(pack, origin, object_frame && !expand);
  if (near_light_ != nullptr) {
    total_light_ = makeLightBuffer();
    sum_program_ = makeComputeProgram({kSumLightsComp});
  }
}

void ExitRadiance::setDistantLight(std::span<const transport::Float3> light) {
  const std::size_t count = transport::coefficientCount(order_);
  if (light.size() < count) throw std::invalid_argument("the light has too few coefficients");
  setLight(distant_light_, light.first(count));
  distant_is_stale_ = true;
}

void ExitRadiance::sumLights() {
  glUseProgram(sum_program_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, distant_light_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, near_light_->name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, total_light_.name());
  dispatchItems(transport::coefficientCount(transport::kMaxOrder));
  glMemoryBarrier(GL_UNIFORM_BARRIER_BIT);
}

void ExitRadiance::update() {
  const bool near_is_stale = near_light_ != nullptr && near_is_stale_;
  if (!distant_is_stale_ && !near_is_stale) return;
  if (distant_is_stale_) distant_->evaluate(distant_light_);
  if (near_) near_->evaluate(*near_light_, &distant_->buffer());
  if (transfer_) {
    if (near_light_ != nullptr) sumLights();
    transfer_->evaluate(near_light_ != nullptr ? total_light_ : distant_light_);
  }
  distant_is_stale_ = near_is_stale_ = false;
}

void ExitRadiance::lookFrom(const transport::Vec3& eye) {
  update();
  if (glossy_) glossy_->evaluate(eye, transfer_->buffer(), (near_ ? *near_ : *distant_).buffer());
}

const Buffer& ExitRadiance::buffer() const {
  return glossy_ ? glossy_->buffer() : (near_ ? *near_ : *distant_).buffer();
}

std::size_t ExitRadiance::gpuBytes() const {
  std::size_t bytes = vectors_.gpuBytes() + near_vectors_.gpuBytes() + sizeInBytes(vertex_colors_) +
                      sizeInBytes(distant_light_) + sizeInBytes(total_light_) +
                      sizeInBytes(distant_->buffer());
  if (near_) bytes += sizeInBytes(near_->buffer());
  if (transfer_) bytes += transfer_->gpuBytes();
  if (glossy_) bytes += glossy_->gpuBytes();
  return bytes;
}

}  // namespace bakelight::player
