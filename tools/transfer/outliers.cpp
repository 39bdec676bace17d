#include "tools/transfer/outliers.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "transport/directions.h"
#include "transport/sh.h"

namespace bakelight::transfer {

using formats::TriangleMesh;
using transport::coefficientCount;
using transport::float3;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr int kLamps = 64;
// A lamp's bands are windowed, as an unwindowed one rings: dark rings around it that are no shadows.
constexpr double kWindow = 0.01;
// Neighbours that face elsewhere are lit otherwise by right.
constexpr float kSameWay = 0.7f;
constexpr int kFewNeighbors = 3;
constexpr double kRangeShare = 0.5;
// Beyond the noise of shadow edges between a point and samples right beside it.
constexpr double kAlone = 0.02;
constexpr std::size_t kVerticesPerTask = 256;

// Lamps of such brightness that the unshadowed transfer vector that faces one shows 1.
std::vector<float> lampsAround() {
  const std::vector<double> cosine = transport::clampedCosineFactors(kJudgedOrder);
  std::vector<double> zonal;  // on the coefficients of y(direction)
  double facing = 0;
  for (int l = 0; l < kJudgedOrder; ++l) {
    zonal.push_back(1 / (1 + kWindow * std::pow(l * (l + 1), 2)));
    facing += cosine[l] / std::numbers::pi * zonal[l] * (2 * l + 1) / (4 * std::numbers::pi);
  }
  std::vector<float> lamps;
  for (const Vec3& direction : transport::sphereDirections(kLamps)) {
    const std::vector<double> basis = transport::evaluateSh(kJudgedOrder, direction);
    for (int l = 0; l < kJudgedOrder; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i)
        lamps.push_back(static_cast<float>(basis[i] * zonal[l] / facing));
  }
  return lamps;
}

float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

constexpr std::size_t kJudged = coefficientCount(kJudgedOrder);

float shown(const float* vector, const float* lamp) {
  float sum = 0;
  for (std::size_t i = 0; i < kJudged; ++i) sum += vector[i] * lamp[i];
  return sum;
}

}  // namespace

IncidentTriangles::IncidentTriangles(const TriangleMesh& mesh)
    : begin_(mesh.vertexCount() + 1, 0), triangles_(3 * mesh.triangleCount()) {
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) ++begin_[v + 1];
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) begin_[v + 1] += begin_[v];
  std::vector<std::uint32_t> end(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) triangles_[end[v]++] = t;
}

OutlierJudge::OutlierJudge(const TriangleMesh& mesh, const IncidentTriangles& incident,
                           std::span<const float> vectors, std::size_t row_size,
                           std::span<const std::uint8_t> left_out)
    : mesh_(mesh),
      incident_(incident),
      vectors_(vectors),
      row_size_(row_size),
      left_out_(left_out),
      lamps_(lampsAround()) {}

double OutlierJudge::score(std::uint32_t vertex, std::span<const float> vector) const {
  std::vector<std::uint32_t> neighbors;
  for (const std::uint32_t t : incident_.of(vertex))
    for (const std::uint32_t v : mesh_.triangles[t])
      if (v != vertex && left_out_[v] == 0 && dot(mesh_.normals[v], mesh_.normals[vertex]) > kSameWay)
        neighbors.push_back(v);
  std::sort(neighbors.begin(), neighbors.end());
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  if (neighbors.size() < kFewNeighbors) return 0;

  double worst = -std::numeric_limits<double>::infinity();
  for (std::size_t at = 0; at < lamps_.size(); at += kJudged) {
    const float* lamp = &lamps_[at];
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const std::uint32_t v : neighbors) {
      const double neighbor = shown(&vectors_[v * row_size_], lamp);
      low = std::min(low, neighbor);
      high = std::max(high, neighbor);
    }
    const double own = shown(vector.data(), lamp);
    worst = std::max(worst, std::max(low - own, own - high) - kRangeShare * (high - low));
  }
  return worst;
}

bool OutlierJudge::standsAlone(std::uint32_t vertex, std::span<const float> area) const {
  double worst = 0;
  for (std::size_t at = 0; at < lamps_.size(); at += kJudged) {
    const float* lamp = &lamps_[at];
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t row = 0; row < area.size(); row += row_size_) {
      const double sample = shown(&area[row], lamp);
      low = std::min(low, sample);
      high = std::max(high, sample);
    }
    const double own = shown(&vectors_[vertex * row_size_], lamp);
    worst = std::max(worst, std::max(low - own, own - high));
  }
  return worst > kAlone;
}

std::vector<std::uint32_t> OutlierJudge::outliers() const {
  std::vector<double> scores(mesh_.vertexCount(), 0);
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, scores.size(), kVerticesPerTask), [&](const auto& range) {
        for (std::size_t v = range.begin(); v < range.end(); ++v)
          if (left_out_[v] == 0)
            scores[v] = score(static_cast<std::uint32_t>(v), vectors_.subspan(v * row_size_, row_size_));
      });
  std::vector<std::uint32_t> found;
  for (std::uint32_t v = 0; v < scores.size(); ++v)
    if (scores[v] > kOutlierScore) found.push_back(v);
  std::stable_sort(found.begin(), found.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return scores[a] > scores[b]; });
  return found;
}

namespace {

// Where the hat function has the share `quantile` of its volume beyond: its value there. Over a triangle, the
// value has the density 6 h (1 − h).
double hatValue(double quantile) {
  // h² (3 − 2h) = quantile
  return 0.5 - std::sin(std::asin(1 - 2 * quantile) / 3);
}

double fraction(double x) {
  return x - std::floor(x);
}

}  // namespace

std::vector<SurfacePoint> hatSamples(const TriangleMesh& mesh, const IncidentTriangles& incident,
                                     std::uint32_t vertex, float offset, int count) {
  const std::span<const std::uint32_t> triangles = incident.of(vertex);
  std::vector<double> area_up_to = {0};
  for (const std::uint32_t t : triangles) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 origin = vec3(mesh.positions[a]);
    area_up_to.push_back(area_up_to.back() +
                         (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin).norm() /
                             2);
  }
  std::vector<SurfacePoint> samples;
  const double area = area_up_to.back();
  for (int k = 0; k < count && area > 0; ++k) {
    // Strata around the fan; the other coordinate by the golden ratio.
    const double around = (k + 0.5) / count * area;
    const auto next = std::upper_bound(area_up_to.begin() + 1, area_up_to.end() - 1, around);
    const auto at = static_cast<std::size_t>(next - area_up_to.begin()) - 1;
    const double across = (around - area_up_to[at]) / (area_up_to[at + 1] - area_up_to[at]);
    const double hat = hatValue(fraction((k + 0.5) * (std::numbers::phi - 1)));
    formats::Triangle corners = mesh.triangles[triangles[at]];
    std::rotate(corners.begin(), std::find(corners.begin(), corners.end(), vertex), corners.end());
    const std::array<double, 3> shares = {hat, (1 - hat) * (1 - across), (1 - hat) * across};
    Vec3 position = Vec3::Zero(), normal = Vec3::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      position += shares[c] * vec3(mesh.positions[corners[c]]);
      normal += shares[c] * vec3(mesh.normals[corners[c]]);
    }
    if (normal.norm() == 0) normal = vec3(mesh.normals[vertex]);
    normal.normalize();
    samples.push_back({float3(position + offset * normal), float3(normal)});
  }
  return samples;
}

}  // namespace bakelight::transfer
