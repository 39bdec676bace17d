#include "tools/transfer/memory_plan.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tools/transfer/bake_setup.h"
#include "tools/transfer/outliers.h"
#include "transport/sh.h"

namespace bakelight::transfer {

namespace {

constexpr std::size_t kGigabyte = 1'000'000'000;
// Measured at a million vertices: the ray tracer's tree and what it copies of the mesh, a triangle.
constexpr std::size_t kTreeBytes = 150;
constexpr std::size_t kProcessBytes = 100'000'000;  // libraries, what threads work with
constexpr std::size_t kPointsPerPilot = 128;
constexpr std::size_t kMostPilots = 2048;
// Pilots may have seen less than the rest.
constexpr double kReserve = 1.08;
constexpr std::size_t kLeastShares = 32;  // a point, whatever the limit

// Mesh, rows and figures: there in each phase.
std::size_t lastingBytes(const BakeSetup& setup, std::size_t points) {
  const std::size_t vertices = setup.vertexCount(), judged = transport::coefficientCount(kJudgedOrder);
  const std::size_t row = std::max(setup.coefficients, judged) + (setup.sphere ? setup.coefficients : 0);
  const std::size_t mesh =
      vertices * (2 * sizeof(Float3) + (setup.mesh.colors.empty() ? 0 : sizeof(Float3))) +
      setup.mesh.triangleCount() * sizeof(formats::Triangle);
  return kProcessBytes + mesh + points * (4 * row + sizeof(PointFigures) + sizeof(Float3)) +
         vertices * 4 * setup.visibility_size;
}

// While rays are traced.
std::size_t tracingBytes(const BakeSetup& setup) {
  const std::size_t masks =
      setup.needsMatrices() ? static_cast<std::size_t>(setup.options.directions) / 16 : 0;
  return setup.mesh.triangleCount() * (kTreeBytes + sizeof(formats::Triangle)) +
         setup.vertexCount() * (sizeof(SurfacePoint) + masks);
}

// While bounces are solved for so many blocks of columns at once.
std::size_t solvingBytes(const BakeSetup& setup, std::size_t points, std::size_t blocks) {
  const std::size_t all = static_cast<std::size_t>(setup.channels) * (setup.sphere ? 2 : 1);
  const std::size_t finished = blocks < all ? 4 * setup.coefficients * all * setup.vertexCount() : 0;
  const std::size_t tracer = setup.needsMatrices() || setup.fitted() ? tracingBytes(setup) : 0;
  const std::size_t exit = setup.fitted() ? fieldBytes(points, all * setup.coefficients) : 0;
  return 2 * setup.vertexCount() * sizeof(std::uint32_t) + finished + tracer + exit +
         kLeastFields * fieldBytes(points, blocks * setup.coefficients);
}

// What evenly spread points see.
std::vector<std::vector<transport::SeenVertex>> pilotRows(const BakeSetup& setup) {
  const std::size_t vertices = setup.vertexCount();
  std::vector<std::vector<transport::SeenVertex>> rows(
      std::clamp(vertices / kPointsPerPilot, std::size_t{1}, kMostPilots));
  tbb::enumerable_thread_specific<ShadowPass::Workspace> workspaces(
      [&] { return ShadowPass::Workspace(*setup.pass); });
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
    const std::size_t vertex = (2 * i + 1) * vertices / (2 * rows.size());
    std::vector<float> vector(transport::coefficientCount(kJudgedOrder));
    std::vector<float> near_vector(setup.sphere ? setup.coefficients : 0);
    rows[i] = setup.pass
                  ->trace(setup.fronts[vertex], setup.sides_from_behind, {vector, near_vector, {}},
                          workspaces.local())
                  .seen;
  });
  return rows;
}

double meanShares(std::span<const std::vector<transport::SeenVertex>> rows, float threshold) {
  std::size_t count = 0;
  for (const auto& row : rows)
    count += threshold > 0 ? transport::countPutTogether(row, threshold) : row.size();
  return static_cast<double>(count) / static_cast<double>(rows.size());
}

// The least threshold that leaves at most `shares` a point.
float thresholdFor(std::span<const std::vector<transport::SeenVertex>> rows, double shares) {
  float low = 1e-9F, high = 1;
  for (int step = 0; step < 40; ++step) {
    const float middle = std::sqrt(low * high);
    (meanShares(rows, middle) > shares ? low : high) = middle;
  }
  return high;
}

}  // namespace

std::size_t defaultMemory(std::size_t vertices) {
  return std::max(2 * kGigabyte, 2000 * vertices);
}

std::size_t fieldBytes(std::size_t points, std::size_t columns) {
  return points * transport::paddedToTiles(columns) * sizeof(float);
}

std::size_t roomForFields(const BakeSetup& setup, std::size_t points, std::size_t share_bytes) {
  const std::size_t beside = lastingBytes(setup, points) + share_bytes + solvingBytes(setup, points, 1) -
                             kLeastFields * fieldBytes(points, setup.coefficients);
  return setup.memory.limit > beside ? setup.memory.limit - beside : 0;
}

MemoryPlan planMemory(const BakeSetup& setup) {
  const std::size_t vertices = setup.vertexCount();
  const std::size_t blocks = static_cast<std::size_t>(setup.channels) * (setup.sphere ? 2 : 1);
  MemoryPlan plan;
  plan.limit = setup.options.memory > 0
                   ? static_cast<std::size_t>(setup.options.memory * static_cast<double>(kGigabyte))
                   : defaultMemory(vertices);
  if (vertices == 0) return plan;
  const auto count = static_cast<double>(vertices);
  // Where all blocks at once leave too little, one after the other will.
  const auto beside = [&](std::size_t at_once) {
    return lastingBytes(setup, vertices) +
           std::max(tracingBytes(setup), solvingBytes(setup, vertices, at_once));
  };
  const auto bytesPerPoint = [&](std::size_t at_once) {
    return plan.limit > beside(at_once) ? static_cast<double>(plan.limit - beside(at_once)) / count : 0.0;
  };
  transport::ShareStorage& storage = plan.shares;
  const auto fit = [&](double shares, std::size_t at_once) {
    return shares * static_cast<double>(storage.bytesPerShare()) <= bytesPerPoint(at_once);
  };
  double shares = std::min(1.5 * setup.options.directions, 2 * count);  // at most
  if (!fit(shares, blocks)) {
    const auto rows = pilotRows(setup);
    shares = kReserve * meanShares(rows, 0);
    if (!fit(shares, 1)) storage.exact = false;
    if (!fit(shares, 1)) {
      const double room =
          std::max<double>(bytesPerPoint(1) / static_cast<double>(storage.bytesPerShare()), kLeastShares);
      storage.threshold = thresholdFor(rows, room / kReserve);
      shares = kReserve * meanShares(rows, storage.threshold);
    }
  }
  plan.expected =
      beside(1) + static_cast<std::size_t>(shares * static_cast<double>(storage.bytesPerShare()) * count);
  return plan;
}

}  // namespace bakelight::transfer
