// Bakes without progress, for tests.
#pragma once

#include <span>

#include "tools/transfer/transfer.h"

namespace bakelight::tests {

inline transfer::Transfer bake(const formats::TriangleMesh& mesh, const transfer::TransferOptions& options,
                               std::span<const formats::Float3> albedo = {}) {
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  return transfer::bakeTransfer(mesh, albedo, options, silent);
}

}  // namespace bakelight::tests
