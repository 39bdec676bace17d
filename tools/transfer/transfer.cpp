#include "tools/transfer/transfer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "tools/transfer/buried.h"
#include "transport/camera.h"
#include "transport/directions.h"
#include "transport/ray_scene.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using formats::Float3;
using formats::TriangleMesh;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr std::size_t kVerticesPerTask = 64;

// Compiled for several instruction sets, the widest at hand chosen when the program starts. The kernels never
// sum across lanes and never fuse a multiplication with an addition, so each of them gives the same bits.
// Sanitizers are not ready yet when that choice is made.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BAKELIGHT_MULTIVERSIONED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define BAKELIGHT_MULTIVERSIONED
#endif

// The quadrature's directions with the basis tabulated, coefficients padded to whole tiles.
struct Quadrature {
  static constexpr int kTile = 32;  // coefficients whose sums stay in registers

  int order = 0, row_size = 0;
  transport::RayBundle directions;
  std::vector<float> basis;  // directions × row_size
  double weight = 0;         // 4π / count

  Quadrature(int sh_order, int count)
      : order(sh_order),
        row_size((transport::coefficientCount(sh_order) + kTile - 1) / kTile * kTile),
        directions(count),
        basis(static_cast<std::size_t>(count) * row_size, 0.0f),
        weight(4 * std::numbers::pi / count) {
    const std::vector<Vec3> lattice = transport::sphereDirections(count);
    tbb::parallel_for(0, count, [&](int d) {
      directions.set(d, transport::float3(lattice[d]));
      std::array<double, transport::coefficientCount(transport::kMaxOrder)> values;
      const int used = transport::coefficientCount(order);
      transport::evaluateSh(order, lattice[d], std::span(values).first(used));
      std::copy_n(values.begin(), used, &basis[static_cast<std::size_t>(d) * row_size]);
    });
  }

  const float* row(std::uint32_t direction) const {
    return &basis[static_cast<std::size_t>(direction) * row_size];
  }
};

// sums[i] += Σ_k weights[k] · basis row of chosen[k]. One tile of coefficients at a time, so that its sums
// stay in registers; in blocks whose float sums go into doubles, so that the error does not grow with the
// number of directions. The order of additions is fixed and no lane is summed across, so every instruction
// set gives the same bits.
BAKELIGHT_MULTIVERSIONED void accumulate(const Quadrature& quadrature, std::span<const std::uint32_t> chosen,
                                         std::span<const float> weights, std::span<double> sums) {
  constexpr std::size_t kBlock = 128;
  constexpr int kTile = Quadrature::kTile;
  for (std::size_t first = 0; first < chosen.size(); first += kBlock) {
    const std::size_t end = std::min(first + kBlock, chosen.size());
    for (int tile = 0; tile < quadrature.row_size; tile += kTile) {
      std::array<float, kTile> partial{};
      for (std::size_t k = first; k < end; ++k) {
        const float* row = quadrature.row(chosen[k]) + tile;
        const float weight = weights[k];
        for (int i = 0; i < kTile; ++i) partial[i] += weight * row[i];
      }
      for (int i = 0; i < kTile; ++i) sums[tile + i] += partial[i];
    }
  }
}

// What one thread reuses from vertex to vertex.
struct Workspace {
  explicit Workspace(std::size_t directions)
      : hemisphere(directions), above(directions), cosines(directions), blocked(directions) {}

  transport::RayBundle hemisphere;
  std::vector<std::uint32_t> above, blocked_directions;
  std::vector<float> cosines, blocked_cosines;
  std::vector<std::uint8_t> blocked;
  std::vector<double> all_sums, blocked_sums;
  std::size_t count = 0;  // directions above the tangent plane; the arrays hold that many
};

// Directions above the tangent plane, compacted: full packets for the tracer. Every direction is written and
// the end moves on only past those above, as the branch would be mispredicted too often.
BAKELIGHT_MULTIVERSIONED void collectHemisphere(const Quadrature& quadrature, const Float3& normal,
                                                Workspace& work) {
  const float* const x = quadrature.directions.x.data();
  const float* const y = quadrature.directions.y.data();
  const float* const z = quadrature.directions.z.data();
  std::size_t end = 0;
  for (std::size_t d = 0; d < quadrature.directions.size(); ++d) {
    const float cosine = normal[0] * x[d] + normal[1] * y[d] + normal[2] * z[d];
    work.hemisphere.x[end] = x[d];
    work.hemisphere.y[end] = y[d];
    work.hemisphere.z[end] = z[d];
    work.above[end] = static_cast<std::uint32_t>(d);
    work.cosines[end] = cosine;
    end += cosine > 0 ? 1 : 0;
  }
  work.count = end;
}

void collectBlocked(Workspace& work) {
  work.blocked_directions.clear();
  work.blocked_cosines.clear();
  for (std::size_t k = 0; k < work.count; ++k)
    if (work.blocked[k] != 0) {
      work.blocked_directions.push_back(work.above[k]);
      work.blocked_cosines.push_back(work.cosines[k]);
    }
}

// What a vertex adds to the totals; reduced in vertex order.
struct VertexFigures {
  std::uint32_t rays = 0, blocked = 0;
  float quadrature_error = 0;
  bool buried = false;
};

class ShadowedBaker {
 public:
  ShadowedBaker(const TriangleMesh& mesh, const DiffuseOptions& options)
      : mesh_(mesh),
        scene_(mesh),
        quadrature_(options.order, options.directions),
        cosine_factors_(transport::clampedCosineFactors(options.order)),
        offset_(static_cast<float>(surfaceOffset(mesh, options.bias))) {}

  std::size_t directionCount() const { return quadrature_.directions.size(); }

  VertexFigures bake(std::size_t vertex, std::span<float> vector, Workspace& work) const {
    collectHemisphere(quadrature_, mesh_.normals[vertex], work);
    Float3 origin;
    for (std::size_t c = 0; c < 3; ++c)
      origin[c] = mesh_.positions[vertex][c] + offset_ * mesh_.normals[vertex][c];
    scene_.occluded(origin, work.hemisphere, 0, std::span(work.blocked).first(work.count));
    collectBlocked(work);

    VertexFigures figures;
    figures.rays = static_cast<std::uint32_t>(work.count);
    figures.blocked = static_cast<std::uint32_t>(work.blocked_directions.size());
    figures.quadrature_error = combine(vertex, vector, work);
    figures.buried = figures.rays > 0 && figures.blocked == figures.rays &&
                     isBuried(mesh_, scene_, origin, mesh_.normals[vertex]);
    return figures;
  }

 private:
  static double surfaceOffset(const TriangleMesh& mesh, double bias) {
    const transport::BoundingSphere bounds = transport::boundingSphere(mesh);
    const double farthest_coordinate = bounds.center.cwiseAbs().maxCoeff() + bounds.radius;
    return std::max(bias * bounds.radius, 4 * std::numeric_limits<float>::epsilon() * farthest_coordinate);
  }

  // Puts closed form and quadrature together (see the header); returns the quadrature's error.
  float combine(std::size_t vertex, std::span<float> vector, Workspace& work) const {
    const int count = transport::coefficientCount(quadrature_.order);
    std::array<double, transport::coefficientCount(transport::kMaxOrder)> exact;
    const Vec3 normal = vec3(mesh_.normals[vertex]);
    transport::evaluateSh(quadrature_.order, normal, std::span(exact).first(count));
    for (int l = 0; l < quadrature_.order; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i) exact[i] *= cosine_factors_[l] / std::numbers::pi;

    if (work.blocked_directions.empty()) {
      std::copy_n(exact.begin(), count, vector.begin());
      return 0;
    }
    work.all_sums.assign(quadrature_.row_size, 0.0);
    work.blocked_sums.assign(quadrature_.row_size, 0.0);
    accumulate(quadrature_, std::span(work.above).first(work.count), work.cosines, work.all_sums);
    accumulate(quadrature_, work.blocked_directions, work.blocked_cosines, work.blocked_sums);

    const bool sees_light = work.blocked_directions.size() < work.count;
    // Coefficient 0 is constant, so its sums are the cosine-weighted counts.
    const double visible = sees_light ? 1 - work.blocked_sums[0] / work.all_sums[0] : 0;
    const double weight = quadrature_.weight / std::numbers::pi;
    double error = 0;
    for (int i = 0; i < count; ++i) {
      const double all = weight * work.all_sums[i], blocked = weight * work.blocked_sums[i];
      vector[i] = sees_light ? static_cast<float>(visible * exact[i] + (1 - visible) * all - blocked) : 0.0f;
      error = std::max(error, std::abs(all - exact[i]));
    }
    return static_cast<float>(error);
  }

  const TriangleMesh& mesh_;
  transport::RayScene scene_;
  Quadrature quadrature_;
  std::vector<double> cosine_factors_;
  float offset_;
};

DiffuseTransfer bakeUnshadowed(const TriangleMesh& mesh, int order, stage::Progress& progress) {
  const int count = transport::coefficientCount(order);
  const std::vector<double> factors = transport::clampedCosineFactors(order);
  DiffuseTransfer result;
  result.vectors.resize(mesh.vertexCount() * count);
  tbb::parallel_for(std::size_t{0}, mesh.vertexCount(), [&](std::size_t vertex) {
    const std::vector<double> basis = transport::evaluateSh(order, vec3(mesh.normals[vertex]));
    for (int l = 0; l < order; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i)
        result.vectors[vertex * count + i] = static_cast<float>(factors[l] / std::numbers::pi * basis[i]);
    progress.advance();
  });
  return result;
}

DiffuseTransfer bakeShadowed(const TriangleMesh& mesh, const DiffuseOptions& options,
                             stage::Progress& progress) {
  const ShadowedBaker baker(mesh, options);
  const std::size_t count = transport::coefficientCount(options.order);
  DiffuseTransfer result;
  result.vectors.resize(mesh.vertexCount() * count);
  std::vector<VertexFigures> figures(mesh.vertexCount());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, mesh.vertexCount(), kVerticesPerTask), [&](const auto& range) {
        Workspace work(baker.directionCount());
        for (std::size_t vertex = range.begin(); vertex < range.end(); ++vertex)
          figures[vertex] =
              baker.bake(vertex, std::span(result.vectors).subspan(vertex * count, count), work);
        progress.advance(range.size());
      });
  std::vector<std::uint8_t> buried;
  for (const VertexFigures& vertex : figures) {
    buried.push_back(vertex.buried ? 1 : 0);
    result.buried_vertices += vertex.buried ? 1 : 0;
    result.rays += vertex.rays;
    result.blocked_rays += vertex.blocked;
    result.fully_blocked_vertices += vertex.rays > 0 && vertex.blocked == vertex.rays ? 1 : 0;
    result.quadrature_error = std::max<double>(result.quadrature_error, vertex.quadrature_error);
  }
  if (result.buried_vertices > 0) result.filled_vertices = fillBuried(mesh, buried, result.vectors, count);
  return result;
}

}  // namespace

DiffuseTransfer bakeDiffuse(const TriangleMesh& mesh, const DiffuseOptions& options,
                            stage::Progress& progress) {
  return options.visibility == Visibility::kUnshadowed ? bakeUnshadowed(mesh, options.order, progress)
                                                       : bakeShadowed(mesh, options, progress);
}

}  // namespace bakelight::transfer
