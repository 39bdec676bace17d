#include "tools/player/techniques/patch_projection.h"

#include <algorithm>
#include <string>
#include <utility>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/gpu_timer.h"

namespace bakelight::player {

using formats::Float3;
using formats::Float4;

PatchProjection::PatchProjection(const PatchSurface& surface, const std::vector<ProjectedPatch>& patches,
                                 std::span<const Float3> albedo, std::size_t row_values,
                                 std::span<const std::uint32_t> blocks)
    : surface_(surface),
      vertex_count_(albedo.size()),
      row_values_(row_values),
      has_blocks_(!blocks.empty()),
      albedo_(makeBuffer(albedo.size_bytes(), albedo.data())) {
  if (has_blocks_) blocks_ = makeBuffer(blocks.size_bytes(), blocks.data());
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const auto& [source, vertices, incident_values] = patches[p];
    const std::size_t groups = surface.groupsAtOnce(p);
    Patch patch;
    patch.vertices = vertices;
    patch.program = makeComputeProgram(
        {kPatchProjectComp}, std::string(has_blocks_ ? "#define BLOCKS\n" : "") + "#define GROUPS " +
                                 std::to_string(groups) + "\n#define INCIDENT " +
                                 std::to_string(incident_values) + "u\n");
    for (std::size_t draw = 0; draw < surface.drawCount(p); ++draw) {
      const std::vector<float> basis = PatchSurface::basisOf(*source, incident_values, draw * groups, groups);
      patch.bases.push_back(makeBuffer(basis.size() * sizeof(float), basis.data()));
    }
    patches_.push_back(std::move(patch));
  }
  throwIfGlFailed("preparing the projection onto patches");
}

void PatchProjection::run(const Buffer& incident) const {
  const GpuPass pass("project");
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  const std::size_t incident_bytes = row_values_ * sizeof(Float3),
                    projected_bytes = surface_.mostGroups() * 3 * sizeof(Float4);
  const std::vector<RowRange> ranges =
      rowRanges(vertex_count_, has_blocks_ ? projected_bytes : std::max(incident_bytes, projected_bytes), 1);
  if (has_blocks_) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, incident.name());
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    const Patch& patch = patches_[p];
    glUseProgram(patch.program.name());
    glUniform1ui(3, static_cast<GLuint>(surface_.mostGroups()));
    glUniform1ui(4, static_cast<GLuint>(row_values_));
    for (const RowRange& range : ranges) {
      const std::size_t first = std::max(range.first, patch.vertices.first);
      const std::size_t end = std::min(range.first + range.count, patch.vertices.end);
      if (first >= end) continue;
      if (has_blocks_)
        bindRows(4, blocks_, range, sizeof(std::uint32_t));
      else
        bindRows(0, incident, range, incident_bytes);
      bindRows(2, albedo_, range, sizeof(Float3));
      bindRows(3, surface_.projected(), range, projected_bytes);
      glUniform1ui(0, static_cast<GLuint>(end - range.first));
      glUniform1ui(1, static_cast<GLuint>(first - range.first));
      for (std::size_t draw = 0; draw < patch.bases.size(); ++draw) {
        glUniform1ui(2, static_cast<GLuint>(draw * surface_.groupsAtOnce(p)));
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, patch.bases[draw].name());
        dispatchItems(end - first);
      }
    }
  }
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("projecting onto patches");
}

}  // namespace bakelight::player
