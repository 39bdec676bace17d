// A mesh's vertices as synthesis takes them: checked, in an order that keeps neighbors near in memory, one at
// each place, with orthonormal frames.
#pragma once

#include "tools/mesomesh/synthesis/surface_graph.h"

namespace bakelight::mesomesh {

struct SurfaceFrame {
  formats::Float3 position, tangent, bitangent, normal;
};

struct MeshVertices {
  std::vector<SurfaceFrame> frames;
  std::vector<std::uint32_t> exemplars;
  std::vector<std::uint8_t> on_seam;     // 1: several of the mesh's vertices are at its place
  std::vector<std::uint32_t> vertex_of;  // of each of the mesh's
};

MeshVertices meshVertices(const SurfaceView& surface, std::size_t exemplar_count);

}  // namespace bakelight::mesomesh
