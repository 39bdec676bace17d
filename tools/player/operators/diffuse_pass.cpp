#include "tools/player/operators/diffuse_pass.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "transport/sh.h"

namespace bakelight::player {
namespace {

constexpr std::size_t kRadianceBytes = sizeof(formats::Float3);

std::string definitionsOf(const GpuTable& table, int order, int channels, bool colors, bool adds) {
  return table.definitions() + "#define CHANNELS " + std::to_string(channels) + "\n#define COEFFICIENTS " +
         std::to_string(transport::coefficientCount(order)) + "u\n" +
         (colors ? "#define VERTEX_COLORS\n" : "") + (adds ? "#define ADDED\n" : "");
}

}  // namespace

DiffusePass::DiffusePass(const GpuTable& table, int order, int channels, const Albedo& albedo, bool adds,
                         std::size_t largest_block_bytes)
    : table_(table),
      albedo_(albedo),
      ranges_(rowRanges(table.rows(), std::max(table.rowBytes(), kRadianceBytes), 1, largest_block_bytes)),
      program_(
          makeComputeProgram({kTableGlsl, kDiffuseComp},
                             definitionsOf(table, order, channels, albedo.vertex_colors != nullptr, adds))) {
  if (order < 1 || order > transport::kMaxOrder || (channels != 1 && channels != 3) ||
      (!table.empty() &&
       table.columns() != static_cast<std::size_t>(channels) * transport::coefficientCount(order)))
    throw std::invalid_argument("transfer vectors and order do not fit together");
  radiance_ = makeBuffer(table.rows() * kRadianceBytes, nullptr);
  throwIfGlFailed("preparing the diffuse pass");
}

void DiffusePass::evaluate(const Buffer& light, const Buffer* added) {
  glUseProgram(program_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light.name());
  glUniform3fv(1, 1, albedo_.base_color.data());
  for (const RowRange& range : ranges_) {
    table_.bind(range);
    bindRows(2, radiance_, range, kRadianceBytes);
    if (albedo_.vertex_colors != nullptr) bindRows(3, *albedo_.vertex_colors, range, kRadianceBytes);
    if (added != nullptr) bindRows(4, *added, range, kRadianceBytes);
    glUniform1ui(0, static_cast<GLuint>(range.count));
    dispatchItems(range.count);
  }
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT |
                  GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("evaluating the light");
}

}  // namespace bakelight::player
