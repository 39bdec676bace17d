// What a bake goes by in each of its phases, fixed before the first ray: the same for a whole bake and for
// any range of it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tools/transfer/memory_plan.h"
#include "tools/transfer/shadow_pass.h"
#include "tools/transfer/transfer.h"

namespace bakelight::transfer {

struct BakeSetup {
  // Throws std::invalid_argument for options that exclude each other. Keeps `mesh` by reference.
  BakeSetup(const formats::TriangleMesh& mesh, std::span<const Float3> albedo,
            const TransferOptions& options);

  const formats::TriangleMesh& mesh;
  const TransferOptions options;
  std::size_t coefficients;         // a vector, a channel
  std::size_t visibility_size = 0;  // 0 where there are no visibility vectors
  std::vector<Float3> albedo;       // of each vertex
  int channels = 1;
  std::optional<VirtualSphere> sphere;

  // Empty for unshadowed transport.
  std::vector<SurfacePoint> fronts;
  std::vector<formats::Triangle> sides_from_behind;  // where hits are recorded
  std::unique_ptr<transport::RayScene> scene;
  std::unique_ptr<ShadowPass> pass;
  MemoryPlan memory;

  bool interreflected() const { return options.transport == Transport::kInterreflected; }
  bool fitted() const { return options.fit == Fit::kLeastSquares; }
  bool needsMatrices() const { return options.glossy == Glossy::kMatrices; }
  std::size_t vertexCount() const { return mesh.vertexCount(); }
  std::size_t matrixSize() const;
  std::vector<formats::Float4> tangents() const;
};

}  // namespace bakelight::transfer
