// Neighborhood transfer of a ball, made by code.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "formats/neighborhood.h"
#include "tests/support/shapes.h"
#include "tools/neighborhood/neighborhood.h"
#include "transport/sh.h"

namespace bakelight::tests {

// A unit ball that stands on the plane y = 0.
inline formats::TriangleMesh standingBall(int subdivisions = 5) {
  return icosphere(subdivisions, 1, {0, 1, 0});
}

// What each vertex of an unshadowed body sends out, times an albedo.
inline neighborhood::Emitted unshadowedLight(const formats::TriangleMesh& mesh, int order,
                                             const formats::Float3& albedo) {
  const std::vector<double> factors = transport::clampedCosineFactors(order);
  std::vector<float> vectors;
  for (const formats::Float3& normal : mesh.normals) {
    const std::vector<double> basis = transport::evaluateSh(order, vec3(normal));
    for (int l = 0; l < order; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i)
        vectors.push_back(static_cast<float>(factors[static_cast<std::size_t>(l)] *
                                             basis[static_cast<std::size_t>(i)] / std::numbers::pi));
  }
  return neighborhood::emittedBy(vectors, order, 1, mesh.vertexCount(), std::span(&albedo, 1));
}

inline stage::Progress silent(std::size_t points) {
  return stage::Progress(stage::ProgressStyle::kNone, "", points, "points");
}

inline formats::EncodedTable tableOf(const neighborhood::Table& baked, std::size_t columns) {
  return formats::encodeTable(baked.values, columns, formats::Precision::kFloat32, "made", "table");
}

inline formats::Neighborhood groundOf(const formats::TriangleMesh& mesh, const neighborhood::Emitted& emitted,
                                      int cells = 16, double reach = 2, int directions = 2048) {
  const neighborhood::GroundGrid grid =
      neighborhood::groundGrid(mesh, transport::boundingSphere(mesh), cells, reach);
  stage::Progress progress = silent(grid.x.size() * grid.z.size());
  const neighborhood::Table baked = neighborhood::groundTransfer(mesh, emitted, grid, {directions}, progress);
  const auto columns = static_cast<std::size_t>(emitted.channels * emitted.order * emitted.order);
  formats::Neighborhood result;
  result.order = emitted.order;
  result.channels = emitted.channels;
  result.ground = formats::GroundTransfer{grid.level, grid.x, grid.z, tableOf(baked, columns)};
  return result;
}

inline formats::Neighborhood volumeOf(const formats::TriangleMesh& mesh, const neighborhood::Emitted& emitted,
                                      int cells, double reach, int directions,
                                      std::uint64_t* inside = nullptr) {
  auto axes = neighborhood::volumeGrid(mesh, transport::boundingSphere(mesh), cells, reach);
  stage::Progress progress = silent(axes[0].size() * axes[1].size() * axes[2].size());
  const neighborhood::Table baked = neighborhood::volumeTransfer(mesh, emitted, axes, {directions}, progress);
  if (inside != nullptr) *inside = baked.inside_points;
  const auto columns = static_cast<std::size_t>(emitted.channels * formats::kReceivedCoefficients *
                                                emitted.order * emitted.order);
  formats::Neighborhood result;
  result.order = emitted.order;
  result.channels = emitted.channels;
  result.volume = formats::VolumeTransfer{std::move(axes), tableOf(baked, columns)};
  return result;
}

}  // namespace bakelight::tests
