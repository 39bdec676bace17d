#include "tools/transfer/open_horizon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/shapes.h"
#include "tests/unit/transfer/bake.h"
#include "tools/transfer/surface_points.h"
#include "transport/sh.h"
#include "transport/texture_frames.h"

namespace bakelight::transfer {
namespace {

using namespace bakelight::tests;

TransferOptions options(Glossy glossy) {
  return {.order = 3, .transport = Transport::kUnshadowed, .glossy = glossy, .row_order = 4};
}

// Nothing blocks anything then: what is left is the rotation into the vertex's frame; a mirrored one, too.
TEST(OpenHorizon, ConvexBodiesOnlyTurnTheLight) {
  const TriangleMesh sphere = icosphere(1);
  TransferOptions given = options(Glossy::kMatrices);
  for (const Float3& normal : sphere.normals) given.tangents.push_back(transport::anyTangent(normal));
  given.tangents[3][3] = -1;
  Transfer baked = bake(sphere, given);
  openHorizons(sphere, given, baked);
  for (std::size_t v = 0; v < sphere.vertexCount(); ++v) {
    const transport::ShRotation rotation(3, localFromObject(sphere.normals[v], baked.tangents[v]));
    for (int i = 0; i < 16; ++i)
      for (int j = 0; j < 9; ++j) {
        const int l = static_cast<int>(std::sqrt(i));
        const bool inside = i < 9 && l == static_cast<int>(std::sqrt(j));
        EXPECT_NEAR(baked.matrices[(v * 16 + static_cast<std::size_t>(i)) * 9 + static_cast<std::size_t>(j)],
                    inside ? rotation.band(l)(i - l * l, j - l * l) : 0, 2e-5);
      }
  }
}

TEST(OpenHorizon, VisibilityIsOneEverywhere) {
  const TriangleMesh sphere = icosphere(1);
  const TransferOptions given = options(Glossy::kVisibility);
  Transfer baked = bake(sphere, given);
  openHorizons(sphere, given, baked);
  for (std::size_t i = 0; i < baked.visibility.size(); ++i)
    EXPECT_NEAR(baked.visibility[i], i % 36 == 0 ? 2 * std::sqrt(std::numbers::pi) : 0, 1e-5);
}

}  // namespace
}  // namespace bakelight::transfer
