// Light that reaches the vertices of a PatchSurface, projected onto the components of their patches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/techniques/patch_surface.h"

namespace bakelight::player {

// The vertices of a patch, and how many of a row's values it reflects.
struct ProjectedPatch {
  const formats::FactoredPatch* patch = nullptr;
  formats::VertexRange vertices;
  std::size_t incident_values = 0;
};

class PatchProjection {
 public:
  // `row_values`: of a row of incident light, × RGB float32. Row v is vertex v's, or blocks[v] if there are any. `albedo` a vertex.
  // `surface` must outlive it, the patches need not.
  PatchProjection(const PatchSurface& surface, const std::vector<ProjectedPatch>& patches,
                  std::span<const formats::Float3> albedo, std::size_t row_values,
                  std::span<const std::uint32_t> blocks = {});

  // Into what the surface draws. With blocks the whole of `incident` is bound at once.
  void run(const Buffer& incident) const;
  std::size_t gpuBytes() const { return sizeInBytes(albedo_) + (has_blocks_ ? sizeInBytes(blocks_) : 0); }

 private:
  struct Patch {
    formats::VertexRange vertices;
    Program program;
    std::vector<Buffer> bases;  // a draw
  };

  const PatchSurface& surface_;
  std::size_t vertex_count_, row_values_;
  bool has_blocks_;
  Buffer albedo_, blocks_;
  std::vector<Patch> patches_;
};

}  // namespace bakelight::player
