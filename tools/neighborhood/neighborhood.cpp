#include "tools/neighborhood/neighborhood.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/neighborhood.h"
#include "transport/directions.h"
#include "transport/ray_scene.h"
#include "transport/sh.h"
#include "transport/surface_points.h"

namespace bakelight::neighborhood {

using transport::Vec3;

namespace {

constexpr int kMostCoefficients = transport::coefficientCount(transport::kMaxOrder);
// A point sees more of the object's inside than of its outside: it lies within.
constexpr double kInsideShare = 0.5;

std::size_t squared(int order) {
  return static_cast<std::size_t>(transport::coefficientCount(order));
}

// Directions of equal weight over a cap of any angle: a lattice over the sphere, pressed into it, which keeps areas in proportion and neighbours together.
class CapDirections {
 public:
  explicit CapDirections(int count) : lattice_(transport::sphereDirections(count)) {}

  std::size_t size() const { return lattice_.size(); }
  // Around `axis`, up to the angle of that cosine; steradians of each.
  double fill(const Vec3& axis, double cosine, transport::RayBundle& rays) const {
    const Vec3 across = axis.unitOrthogonal(), along = axis.cross(across);
    for (std::size_t i = 0; i < lattice_.size(); ++i) {
      const Vec3& s = lattice_[i];
      const double z = 1 - (1 - s.z()) * (1 - cosine) / 2;
      const double flat = std::hypot(s.x(), s.y());
      const double r = flat > 0 ? std::sqrt(std::max(0.0, 1 - z * z)) / flat : 0;
      rays.set(i, transport::float3((s.x() * r * across + s.y() * r * along + z * axis).normalized()));
    }
    return 2 * std::numbers::pi * (1 - cosine) / static_cast<double>(lattice_.size());
  }

 private:
  std::vector<Vec3> lattice_;
};

struct Workspace {
  transport::RayBundle rays;
  transport::HitBundle hits;

  explicit Workspace(std::size_t size) : rays(size), hits(size) {}
};

// Rays from points to the object, and what comes along those that meet it.
class Gatherer {
 public:
  Gatherer(const formats::TriangleMesh& mesh, const Emitted& emitted, int directions)
      : mesh_(mesh),
        emitted_(emitted),
        scene_(mesh),
        bounds_(transport::boundingSphere(mesh)),
        offset_(transport::surfaceOffset(mesh, transport::kDefaultBias)),
        directions_(directions) {}

  struct Cap {
    Vec3 axis;
    double cosine;
  };
  // In which the object is seen from a point.
  Cap towardsObject(const Vec3& point) const {
    const Vec3 way = bounds_.center - point;
    const double distance = way.norm();
    // A point of the sphere itself sees a half of all directions; within it sees all.
    if (distance <= bounds_.radius) return {Vec3::UnitY(), -1};
    const double sine = bounds_.radius / distance;
    return {way / distance, std::sqrt(std::max(0.0, 1 - sine * sine))};
  }

  // Calls add(direction, weight, change): steradians, and of each channel and j the change ρ T_j − y_j that the hit makes.
  template <class Add>
  void gather(const Vec3& point, const Cap& cap, Workspace& work, Table& figures, std::uint64_t& inside,
              const Add& add) const {
    const double weight = directions_.fill(cap.axis, cap.cosine, work.rays);
    scene_.nearestHits(transport::float3(point), work.rays, offset_, directions_.size(), work.hits);
    const std::size_t size = squared(emitted_.order);
    std::array<double, kMostCoefficients> basis;
    std::array<double, 3 * kMostCoefficients> change;
    figures.rays += directions_.size();
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      if (work.hits.blocked[i] == 0) continue;
      ++figures.hits;
      inside += work.hits.back_face[i];
      const Vec3 s(work.rays.x[i], work.rays.y[i], work.rays.z[i]);
      transport::evaluateSh(emitted_.order, s, std::span(basis).first(size));
      const std::size_t values = static_cast<std::size_t>(emitted_.channels) * size;
      for (std::size_t k = 0; k < values; ++k) change[k] = -basis[k % size];
      // The inside of the object is dark.
      if (work.hits.back_face[i] == 0) addEmitted(work.hits, i, std::span(change).first(values));
      add(s, weight, std::span<const double>(change).first(values));
    }
  }

  Workspace workspace() const { return Workspace(directions_.size()); }

 private:
  void addEmitted(const transport::HitBundle& hits, std::size_t ray, std::span<double> change) const {
    const formats::Triangle& triangle = mesh_.triangles[hits.triangle[ray]];
    const double u = hits.u[ray], v = hits.v[ray];
    const std::array<double, 3> weights = {1 - u - v, u, v};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const float* row = &emitted_.vectors[triangle[corner] * change.size()];
      for (std::size_t k = 0; k < change.size(); ++k)
        change[k] += weights[corner] * static_cast<double>(row[k]);
    }
  }

  const formats::TriangleMesh& mesh_;
  const Emitted& emitted_;
  transport::RayScene scene_;
  transport::BoundingSphere bounds_;
  float offset_;
  CapDirections directions_;
};

// Runs bake(point, row, figures, work) for each point; figures are summed in order.
template <class Bake>
Table bakePoints(std::size_t points, std::size_t columns, const Gatherer& gatherer, stage::Progress& progress,
                 const Bake& bake) {
  Table table;
  table.values.resize(points * columns);
  std::vector<Table> figures(points);
  tbb::enumerable_thread_specific<Workspace> workspaces([&] { return gatherer.workspace(); });
  tbb::parallel_for(std::size_t{0}, points, [&](std::size_t p) {
    bake(p, std::span(table.values).subspan(p * columns, columns), figures[p], workspaces.local());
    progress.advance(1);
  });
  for (const Table& of_point : figures) {
    table.rays += of_point.rays;
    table.hits += of_point.hits;
    table.inside_points += of_point.inside_points;
  }
  return table;
}

// Points within get the mean row of their neighbors that have one, ring by ring.
class InsideFill {
 public:
  InsideFill(const std::array<std::size_t, 3>& counts, std::vector<std::uint8_t> inside)
      : counts_(counts), inside_(std::move(inside)) {}

  void apply(std::span<float> values, std::size_t columns) {
    for (bool any = true; any;) {
      any = false;
      std::vector<std::uint8_t> next = inside_;
      for (std::size_t p = 0; p < inside_.size(); ++p)
        if (inside_[p] != 0 && fill(p, values, columns)) next[p] = 0, any = true;
      inside_ = std::move(next);
    }
  }

 private:
  bool fill(std::size_t point, std::span<float> values, std::size_t columns) const {
    const std::array<std::size_t, 3> at = {point % counts_[0], point / counts_[0] % counts_[1],
                                           point / counts_[0] / counts_[1]};
    const std::array<std::size_t, 3> strides = {1, counts_[0], counts_[0] * counts_[1]};
    std::vector<double> sum(columns);
    int sources = 0;
    const auto take = [&](std::size_t source) {
      if (inside_[source] != 0) return;
      ++sources;
      for (std::size_t k = 0; k < columns; ++k) sum[k] += static_cast<double>(values[source * columns + k]);
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (at[axis] > 0) take(point - strides[axis]);
      if (at[axis] + 1 < counts_[axis]) take(point + strides[axis]);
    }
    if (sources == 0) return false;
    for (std::size_t k = 0; k < columns; ++k)
      values[point * columns + k] = static_cast<float>(sum[k] / sources);
    return true;
  }

  std::array<std::size_t, 3> counts_;
  std::vector<std::uint8_t> inside_;
};

}  // namespace

Emitted emittedBy(std::span<const float> transfer, int order, int baked_channels, std::size_t vertices,
                  std::span<const formats::Float3> albedo) {
  const auto isGrey = [](const formats::Float3& c) { return c[0] == c[1] && c[1] == c[2]; };
  Emitted result;
  result.order = order;
  result.channels = baked_channels == 3 || !std::all_of(albedo.begin(), albedo.end(), isGrey) ? 3 : 1;
  const std::size_t size = squared(order), baked = static_cast<std::size_t>(baked_channels) * size;
  for (std::size_t v = 0; v < vertices; ++v) {
    const formats::Float3& color = albedo[albedo.size() == 1 ? 0 : v];
    for (std::size_t c = 0; c < static_cast<std::size_t>(result.channels); ++c)
      for (std::size_t i = 0; i < size; ++i)
        result.vectors.push_back(color[c] * transfer[v * baked + (baked_channels == 3 ? c * size : 0) + i]);
  }
  return result;
}

Table groundTransfer(const formats::TriangleMesh& mesh, const Emitted& emitted, const GroundGrid& grid,
                     const Options& options, stage::Progress& progress) {
  const Gatherer gatherer(mesh, emitted, options.directions);
  const std::size_t columns = static_cast<std::size_t>(emitted.channels) * squared(emitted.order);
  return bakePoints(grid.x.size() * grid.z.size(), columns, gatherer, progress,
                    [&](std::size_t p, std::span<float> row, Table& figures, Workspace& work) {
                      const Vec3 point(grid.x[p % grid.x.size()], grid.level, grid.z[p / grid.x.size()]);
                      Gatherer::Cap cap = gatherer.towardsObject(point);
                      if (cap.cosine < 0)
                        cap = {Vec3::UnitY(), 0};  // only what is above the plane falls on it
                      std::vector<double> sums(columns);
                      std::uint64_t inside = 0;
                      gatherer.gather(point, cap, work, figures, inside,
                                      [&](const Vec3& s, double weight, std::span<const double> change) {
                                        if (!(s.y() > 0)) return;
                                        const double share = weight * s.y() / std::numbers::pi;
                                        for (std::size_t k = 0; k < columns; ++k)
                                          sums[k] += share * change[k];
                                      });
                      for (std::size_t k = 0; k < columns; ++k) row[k] = static_cast<float>(sums[k]);
                    });
}

Table volumeTransfer(const formats::TriangleMesh& mesh, const Emitted& emitted,
                     const std::array<std::vector<float>, 3>& axes, const Options& options,
                     stage::Progress& progress) {
  const Gatherer gatherer(mesh, emitted, options.directions);
  const std::size_t size = squared(emitted.order);
  const std::size_t matrix = formats::kReceivedCoefficients * size;
  const std::size_t columns = static_cast<std::size_t>(emitted.channels) * matrix;
  const std::array<std::size_t, 3> counts = {axes[0].size(), axes[1].size(), axes[2].size()};
  const std::size_t points = counts[0] * counts[1] * counts[2];
  const auto isOutermost = [&](std::size_t x, std::size_t y, std::size_t z) {
    return x == 0 || z == 0 || x + 1 == counts[0] || y + 1 == counts[1] || z + 1 == counts[2];
  };
  std::vector<std::uint8_t> within(points);
  Table table = bakePoints(
      points, columns, gatherer, progress,
      [&](std::size_t p, std::span<float> row, Table& figures, Workspace& work) {
        const std::size_t x = p % counts[0], y = p / counts[0] % counts[1], z = p / counts[0] / counts[1];
        if (isOutermost(x, y, z)) return;
        const Vec3 point(axes[0][x], axes[1][y], axes[2][z]);
        std::vector<double> sums(columns);
        std::array<double, transport::coefficientCount(5)> received;
        std::uint64_t inside = 0;
        gatherer.gather(point, gatherer.towardsObject(point), work, figures, inside,
                        [&](const Vec3& s, double weight, std::span<const double> change) {
                          transport::evaluateSh(5, s, received);
                          for (std::size_t c = 0; c < static_cast<std::size_t>(emitted.channels); ++c)
                            for (int i = 0; i < formats::kReceivedCoefficients; ++i) {
                              const double share =
                                  weight *
                                  received[static_cast<std::size_t>(formats::receivedCoefficient(i))];
                              double* to = &sums[c * matrix + static_cast<std::size_t>(i) * size];
                              for (std::size_t j = 0; j < size; ++j) to[j] += share * change[c * size + j];
                            }
                        });
        for (std::size_t k = 0; k < columns; ++k) row[k] = static_cast<float>(sums[k]);
        if (static_cast<double>(inside) > kInsideShare * static_cast<double>(figures.rays))
          within[p] = 1, figures.inside_points = 1;
      });
  InsideFill(counts, std::move(within)).apply(table.values, columns);
  return table;
}

}  // namespace bakelight::neighborhood
