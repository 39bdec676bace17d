#include "tools/transfer/unshadowed.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>

#include "tools/transfer/matrices.h"
#include "tools/transfer/sample_phase.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using transport::vec3;

namespace {

constexpr std::size_t kPointsPerTask = 64;

void bakeVectors(const BakeSetup& setup, stage::Progress& progress, Transfer& result) {
  const int order = setup.options.order;
  const std::size_t size = setup.coefficients, vertices = setup.vertexCount();
  const std::vector<double> factors = cosineFactors(order, setup.options.entered_ior);
  result.vectors.resize(vertices * size);
  if (setup.sphere) result.near_vectors.resize(vertices * size);
  const Quadrature quadrature(order, setup.sphere ? setup.options.directions : 1);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices, kPointsPerTask), [&](const auto& range) {
    Hemisphere hemisphere(quadrature.size());
    std::vector<double> difference(size);
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      const formats::Float3& normal = setup.mesh.normals[v];
      const std::vector<double> basis = transport::evaluateSh(order, vec3(normal));
      float* vector = &result.vectors[v * size];
      for (int l = 0; l < order; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i)
          vector[i] = static_cast<float>(factors[l] / std::numbers::pi * basis[i]);
      if (!setup.sphere) continue;
      hemisphere.collect(quadrature, normal);
      if (setup.options.entered_ior > 0) hemisphere.enter(setup.options.entered_ior);
      nearFieldDifference(*setup.sphere, vec3(setup.mesh.positions[v]), order, quadrature,
                          hemisphere.usedDirections(), hemisphere.usedCosines(), difference);
      for (std::size_t i = 0; i < size; ++i)
        result.near_vectors[v * size + i] = static_cast<float>(vector[i] + difference[i]);
    }
    progress.advance(range.size());
  });
}

void bakeVisibility(const BakeSetup& setup, Transfer& result) {
  const int order = setup.options.row_order + setup.options.order - 1;
  const std::vector<double> zonal = transport::diskLightZonal(order, std::numbers::pi / 2);
  result.visibility.resize(setup.vertexCount() * setup.visibility_size);
  tbb::parallel_for(std::size_t{0}, setup.vertexCount(), [&](std::size_t v) {
    const std::vector<double> hemisphere =
        transport::orientZonal(zonal, vec3(setup.mesh.normals[v]).normalized());
    std::copy(hemisphere.begin(), hemisphere.end(), &result.visibility[v * setup.visibility_size]);
  });
}

}  // namespace

Transfer bakeUnshadowed(const BakeSetup& setup, stage::Progress& progress) {
  Transfer result;
  result.channels = setup.channels;
  if (setup.sphere) result.sphere = *setup.sphere;
  bakeVectors(setup, progress, result);
  if (setup.fitted()) fitToSamples(setup, nullptr, {}, result, &progress);
  if (setup.options.glossy == Glossy::kNone) return result;
  result.tangents = setup.tangents();
  bakeVisibility(setup, result);
  if (!setup.needsMatrices()) return result;

  const MatrixBaker baker(setup.options.row_order, setup.options.order);
  const std::size_t size = setup.matrixSize();
  result.matrices.resize(setup.vertexCount() * size);
  tbb::parallel_for(std::size_t{0}, setup.vertexCount(), [&](std::size_t v) {
    const auto matrix = std::span(result.matrices).subspan(v * size, size);
    baker.fromVisibility(
        std::span(result.visibility).subspan(v * setup.visibility_size, setup.visibility_size), matrix);
    baker.turnRows(localFromObject(setup.mesh.normals[v], result.tangents[v]), matrix);
  });
  result.visibility.clear();
  return result;
}

}  // namespace bakelight::transfer
