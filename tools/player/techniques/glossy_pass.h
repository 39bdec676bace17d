// Glossy shading: a compute shader that reflects transferred radiance towards the eye at each vertex. Runs in
// every frame. transport::VertexShading does the same on the CPU.
#pragma once

#include <cstddef>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/surface_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::player {

class GlossyPass {
 public:
  // `pack` has glossy transfer, and a reflection other than Lambert; `mesh`, the pack's, outlives the pass.
  // `object_frame`: the transferred radiance is in the object's frame (lobes only). Throws
  // std::invalid_argument for sizes that do not fit together. `largest_block_bytes`: see rowRanges.
  GlossyPass(const formats::Pack& pack, const SurfaceMesh& mesh, bool object_frame,
             std::size_t largest_block_bytes = 0);

  // `eye` in the object's space; `transferred` from a TransferOperator, `diffuse` n × RGB, which is added.
  // Cost: 6 · output_order² multiply-adds a vertex, and the basis functions.
  void evaluate(const transport::Vec3& eye, const Buffer& transferred, const Buffer& diffuse) const;

  // n × RGB float32; fit for a vertex attribute.
  const Buffer& buffer() const { return radiance_; }
  std::size_t gpuBytes() const;

 private:
  // Vertices that reflect alike.
  struct Reflection {
    formats::VertexRange vertices;
    Program program;
    std::vector<float> kernel;  // empty for a BRDF table
    formats::Float3 specular_color = {1, 1, 1};
    Buffer brdf;
  };
  void evaluate(const Reflection& reflection, const Buffer& transferred, const Buffer& diffuse,
                const formats::Float3& eye_from_origin) const;

  const SurfaceMesh& mesh_;
  std::size_t transferred_bytes_;  // a vertex
  std::vector<RowRange> ranges_;
  std::vector<Reflection> reflections_;
  bool some_are_diffuse_ = false;
  Buffer normals_, tangents_, radiance_;
};

}  // namespace bakelight::player
