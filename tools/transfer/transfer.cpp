#include "tools/transfer/transfer.h"

#include "tools/transfer/bake_setup.h"
#include "tools/transfer/solve_phase.h"
#include "tools/transfer/stopwatch.h"
#include "tools/transfer/trace_phase.h"
#include "tools/transfer/unshadowed.h"

namespace bakelight::transfer {

Transfer bakeTransfer(const formats::TriangleMesh& mesh, std::span<const formats::Float3> albedo,
                      const TransferOptions& options, stage::Progress& progress) {
  BakeSetup setup(mesh, albedo, options);
  if (options.transport == Transport::kUnshadowed) return bakeUnshadowed(setup, progress);
  const MemoryPlan memory = setup.memory;
  const Stopwatch watch;
  TracedPoints fronts = traceFronts(setup, {0, mesh.vertexCount()}, progress);
  const double trace_s = watch.seconds();
  Transfer baked = solve(std::move(setup), std::move(fronts), &progress);
  baked.shadow_s += trace_s;
  baked.memory_limit = memory.limit;
  baked.memory_expected = memory.expected;
  baked.exact_shares = memory.shares.exact;
  baked.share_threshold = memory.shares.threshold;
  return baked;
}

}  // namespace bakelight::transfer
