#include "tools/kernels/throughput.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "tools/kernels/point_index.h"

namespace bakelight::kernels {
namespace {

// Of spacings: hats follow what is smooth over that much; measured on plates (docs/TRANSLUCENCY.md).
constexpr float kSmoothing = 1.5F;
// Far knots are that many spacings apart, and the same of theirs is smoothed.
constexpr double kFarSpacings[] = {4, 3, 2};  // the first at which they can follow how fast R_d falls off
constexpr double kFarSmoothing = 2.2;
constexpr float kLeastFall = 0.25F;        // of R_d from there to a far knot's spacing farther
constexpr float kTouching = 0.2F;          // of the radius within which R_d is smoothed
constexpr std::size_t kFewKnots = 1500;    // whose pairs are fewer than what far knots cost
constexpr std::size_t kFewWays = 100;      // knots from which some ways are looked at
constexpr std::size_t kFarNeighbors = 16;  // of a quadratic fit, which has 10 terms in space and 6 on a plane
constexpr double kMostWeight = 4;          // Σ |weights| of a fit that is still one

struct Rows {
  std::vector<std::vector<std::uint32_t>> columns;
  std::vector<std::vector<float>> values;

  explicit Rows(std::size_t count) : columns(count), values(count) {}
  // Rows go as they are joined, so that they are not there twice.
  Matrix joined(std::size_t value_columns) && {
    std::size_t count = 0;
    for (const auto& row : columns) count += row.size();
    Matrix matrix;
    matrix.value_columns = value_columns;
    matrix.columns.reserve(count);
    matrix.values.reserve(count * value_columns);
    for (std::size_t r = 0; r < columns.size(); ++r) {
      matrix.columns.insert(matrix.columns.end(), columns[r].begin(), columns[r].end());
      matrix.values.insert(matrix.values.end(), values[r].begin(), values[r].end());
      matrix.ends.push_back(static_cast<std::uint32_t>(matrix.columns.size()));
      columns[r] = {};
      values[r] = {};
    }
    return matrix;
  }
};

void requireRoom(std::uint64_t factors) {
  if (factors > Throughput::kMostFactors)
    throw std::length_error("some " + std::to_string(factors / 1'000'000) +
                            " million factors between vertices");
}

void push(std::vector<float>& values, const Rgb& rgb) {
  values.insert(values.end(), {rgb[0], rgb[1], rgb[2]});
}

}  // namespace

void alongSurface(const Knots& knots, std::size_t from, double radius, std::vector<std::uint32_t>& found) {
  found.assign(1, static_cast<std::uint32_t>(from));
  for (std::size_t next = 0; next < found.size(); ++next)
    for (const std::uint32_t other : knots.ring(found[next])) {
      if ((knots.positions[other] - knots.positions[from]).squaredNorm() > radius * radius) continue;
      if (std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
    }
  std::sort(found.begin(), found.end());
}

Throughput::Throughput(const Knots& knots, const Reflectance& reflectance, const Options& options)
    : knots_(knots), reflectance_(reflectance), options_(options) {
  for (const float spacing : knots.spacings) smoothing_.push_back(kSmoothing * spacing);
  chooseFarKnots();
  if (has_far_) makeSpread(), makeFar();
  makeNear();
}

// Whether points `cell` apart can follow what is smooth over a radius. Of a medium that varies, what passes along ways of that length that
// there are, all together.
bool Throughput::isFollowed(double radius, double cell) const {
  Rgb at = Rgb::Zero(), beyond = Rgb::Zero();
  const auto look = [&](const Place& place) {
    at += reflectance_.exact(static_cast<float>(radius), place);
    beyond += reflectance_.exact(static_cast<float>(radius + cell), place);
  };
  if (reflectance_.isUniform()) {
    look(Place());
  } else {
    const PointIndex index(knots_.positions);
    std::vector<std::uint32_t> within;
    for (std::size_t k = 0; k < kFewWays; ++k) {
      const Point from = knots_.point(k * knots_.count() / kFewWays);
      index.within(from.position, radius, within);
      std::size_t seen = 0;
      for (const std::uint32_t other : within)
        if ((knots_.positions[other] - from.position).norm() > 0.8 * radius && seen++ % 8 == 0)
          look(reflectance_.along(from, knots_.point(other)));
    }
  }
  return (beyond >= kLeastFall * at).all();
}

// One of each cell of a grid: that nearest to the middle of those in it. Cells as large as R_d allows.
void Throughput::chooseFarKnots() {
  double cell = kFarSpacings[0] * knots_.meanSpacing();
  outer_smoothing_ = static_cast<float>(kFarSmoothing * cell);
  if (options_.hierarchical && knots_.count() >= kFewKnots &&
      reflectance_.reach(1e-3) >= 1.5 * kFarSmoothing * cell)
    for (const double spacings : kFarSpacings) {
      cell = spacings * knots_.meanSpacing();
      has_far_ = isFollowed(kFarSmoothing * cell, cell);
      if (!has_far_) continue;
      outer_smoothing_ = static_cast<float>(kFarSmoothing * cell);
      break;
    }
  // Where triangles are large, what is near must not reach farther than that.
  for (float& radius : smoothing_) radius = std::min(radius, outer_smoothing_);
  if (!has_far_) return;
  std::map<std::array<std::int64_t, 3>, std::vector<std::uint32_t>> cells;
  for (std::size_t k = 0; k < knots_.count(); ++k) {
    std::array<std::int64_t, 3> key{};
    for (int c = 0; c < 3; ++c)
      key[static_cast<std::size_t>(c)] = static_cast<std::int64_t>(std::floor(knots_.positions[k][c] / cell));
    cells[key].push_back(static_cast<std::uint32_t>(k));
  }
  for (const auto& [key, members] : cells) {
    Vec3 middle = Vec3::Zero();
    for (const std::uint32_t k : members) middle += knots_.positions[k] / static_cast<double>(members.size());
    const auto nearest =
        std::min_element(members.begin(), members.end(), [&](std::uint32_t a, std::uint32_t b) {
          return (knots_.positions[a] - middle).squaredNorm() < (knots_.positions[b] - middle).squaredNorm();
        });
    far_points_.push_back(knots_.point(*nearest));
  }
  requireRoom(std::uint64_t{far_points_.size()} * far_points_.size());
}

// R_d between two hats, which are three corners' thirds of their triangles: by the middle of each.
Rgb Throughput::apart(std::size_t a, std::size_t b) const {
  const auto oneWay = [&](std::size_t from, std::size_t to) {
    Rgb sum = Rgb::Zero();
    double area = 0;
    for (const std::uint32_t t : knots_.fan(to)) {
      Vec3 middle = knots_.positions[to] / 4;
      for (const std::uint32_t k : knots_.triangles[t]) middle += knots_.positions[k] / 4;
      Surroundings around;
      for (std::size_t scale = 0; scale < around.size() && !knots_.surroundings.empty(); ++scale) {
        around[scale] = knots_.surroundings[to][scale] / 4;
        for (const std::uint32_t k : knots_.triangles[t]) around[scale] += knots_.surroundings[k][scale] / 4;
      }
      sum += static_cast<float>(knots_.triangle_areas[t]) *
             reflectance_.exact(static_cast<float>((middle - knots_.positions[from]).norm()),
                                reflectance_.along({middle, &around}, knots_.point(from)));
      area += knots_.triangle_areas[t];
    }
    return area > 0 ? Rgb(sum / static_cast<float>(area)) : Rgb(Rgb::Zero());
  };
  return (oneWay(a, b) + oneWay(b, a)) / 2;
}

// Of a knot among others as far apart as most.
double Throughput::hatArea() const {
  return knots_.meanSpacing() * knots_.meanSpacing() * std::sqrt(3.0) / 2;
}

// Beyond it every factor is below the threshold.
double Throughput::reachOfFactors(double hat_area) const {
  const auto isFactor = [&](double distance) {
    return static_cast<double>(reflectance_.greatest(static_cast<float>(distance))) * hat_area >=
           options_.threshold;
  };
  double reach = static_cast<double>(outer_smoothing_);
  while (isFactor(reach) && reach < reflectance_.farthest()) reach *= 1.1;
  return reach;
}

// What passes between a knot and each far knot, by way of the others around it; nothing of a uniform medium, where it is the smoothed R_d.
// Of another, ways between far knots are not that between the knots.
std::vector<Rgb> Throughput::byWayOfFar(std::size_t knot) const {
  if (!has_far_ || reflectance_.isUniform()) return {};
  std::vector<Rgb> sums(farCount(), Rgb::Zero());
  for (std::size_t e = knot == 0 ? 0 : spread_.ends[knot - 1]; e < spread_.ends[knot]; ++e) {
    const float* row = &far_.values[3 * farCount() * spread_.columns[e]];
    for (std::size_t b = 0; b < sums.size(); ++b)
      sums[b] += spread_.values[e] * Eigen::Map<const Rgb>(row + 3 * b);
  }
  return sums;
}

// What far knots give of what passes between it and another one.
Rgb Throughput::givenByFar(const std::vector<Rgb>& by_way_of_far, std::size_t knot, float distance) const {
  if (!has_far_) return Rgb::Zero();
  if (by_way_of_far.empty()) return reflectance_.smoothed(distance, outer_smoothing_, Place());
  Rgb sum = Rgb::Zero();
  for (std::size_t e = knot == 0 ? 0 : spread_.ends[knot - 1]; e < spread_.ends[knot]; ++e)
    sum += spread_.values[e] * by_way_of_far[spread_.columns[e]];
  return sum;
}

void Throughput::makeNear() {
  const std::size_t count = knots_.count();
  const PointIndex index(knots_.positions);
  const double hat_area = hatArea();
  const double reach = has_far_ ? static_cast<double>(outer_smoothing_) : reachOfFactors(hat_area);
  // What lies beyond that is dropped, on a plane at most so much.
  const double beyond = has_far_ || reach >= reflectance_.farthest() ? 0 : reflectance_.shareBeyond(reach);
  std::vector<std::uint32_t> sample;
  index.within(knots_.positions[count / 2], reach, sample);
  requireRoom(std::uint64_t{sample.size()} * count / 4);  // of one knot's; others may have some times as many
  Rows rows(count);
  std::vector<double> dropped(count, 0);
  std::vector<std::size_t> apart_pairs(count, 0);
  std::vector<std::uint8_t> touches(count, 0);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    std::vector<std::uint32_t> near, along;
    index.within(knots_.positions[i], reach, near);
    alongSurface(knots_, i, 1.5 * static_cast<double>(smoothing_[i]), along);
    const std::vector<Rgb> by_way_of_far = byWayOfFar(i);
    for (const std::uint32_t j : near) {
      const auto distance = static_cast<float>((knots_.positions[i] - knots_.positions[j]).norm());
      const float radius = (smoothing_[i] + smoothing_[j]) / 2;
      const bool is_apart = distance < radius && !std::binary_search(along.begin(), along.end(), j);
      Rgb value = is_apart ? apart(i, j) : between(i, j);
      apart_pairs[i] += is_apart;
      touches[i] |= is_apart && distance < kTouching * radius;
      value -= givenByFar(by_way_of_far, j, distance);
      if (static_cast<double>(value.abs().maxCoeff()) * hat_area < options_.threshold && j != i) {
        dropped[i] += static_cast<double>(value.abs().maxCoeff()) * knots_.areas[j];
        continue;
      }
      rows.columns[i].push_back(j);
      push(rows.values[i], value);
    }
  });
  std::uint64_t factors = 0;
  for (const auto& row : rows.columns) factors += row.size();
  requireRoom(factors);
  near_ = std::move(rows).joined(3);
  figures_.dropped_share = beyond + *std::max_element(dropped.begin(), dropped.end());
  for (std::size_t i = 0; i < count; ++i) {
    figures_.apart_pairs += apart_pairs[i];
    figures_.touching_knots += touches[i];
  }
}

// Moving least squares: weights of far knots around a knot that reproduce quadratic functions of space, those nearby more.
void Throughput::makeSpread() {
  std::vector<Vec3> far_positions;
  for (const Point& point : far_points_) far_positions.push_back(point.position);
  const PointIndex index(far_positions);
  Rows rows(knots_.count());
  tbb::parallel_for(std::size_t{0}, knots_.count(), [&](std::size_t i) {
    std::vector<std::uint32_t> near;
    index.nearest(knots_.positions[i], kFarNeighbors, near);
    const double scale = std::max((far_positions[near.back()] - knots_.positions[i]).norm(), 1e-300);
    const auto n = static_cast<Eigen::Index>(near.size());
    Eigen::VectorXd weights;
    for (const int terms : {10, 4, 1}) {
      // Minimises Σ w_k² / θ_k under P w = p(0): w = Θ^½ (P Θ^½)⁺ p(0).
      Eigen::MatrixXd p(terms, n);
      Eigen::VectorXd root(n);
      for (Eigen::Index k = 0; k < n; ++k) {
        const Vec3 d = (far_positions[near[static_cast<std::size_t>(k)]] - knots_.positions[i]) / scale;
        root[k] = std::exp(-3 * d.squaredNorm());
        const double all[10] = {1,
                                d.x(),
                                d.y(),
                                d.z(),
                                d.x() * d.x(),
                                d.y() * d.y(),
                                d.z() * d.z(),
                                d.x() * d.y(),
                                d.y() * d.z(),
                                d.z() * d.x()};
        for (int t = 0; t < terms; ++t) p(t, k) = all[t] * root[k];
      }
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
      decomposition.setThreshold(1e-3);  // nearly flat neighborhoods have no third dimension to fit
      decomposition.compute(p);
      weights = root.cwiseProduct(decomposition.solve(Eigen::VectorXd::Unit(terms, 0)));
      weights /= weights.sum();
      if (weights.allFinite() && weights.cwiseAbs().sum() < kMostWeight) break;
    }
    std::vector<std::pair<std::uint32_t, float>> entries;
    for (Eigen::Index k = 0; k < n; ++k)
      entries.emplace_back(near[static_cast<std::size_t>(k)], static_cast<float>(weights[k]));
    std::sort(entries.begin(), entries.end());
    for (const auto& [column, value] : entries)
      rows.columns[i].push_back(column), rows.values[i].push_back(value);
  });
  spread_ = std::move(rows).joined(1);
}

void Throughput::makeFar() {
  Rows rows(far_points_.size());
  tbb::parallel_for(std::size_t{0}, far_points_.size(), [&](std::size_t a) {
    for (std::size_t b = 0; b < far_points_.size(); ++b) {
      const Point &from = far_points_[a], &to = far_points_[b];
      rows.columns[a].push_back(static_cast<std::uint32_t>(b));
      push(rows.values[a], reflectance_.smoothed(static_cast<float>((from.position - to.position).norm()),
                                                 outer_smoothing_, reflectance_.along(from, to)));
    }
  });
  far_ = std::move(rows).joined(3);
}

std::vector<Rgb> multiply(const Matrix& matrix, const std::vector<Rgb>& x) {
  std::vector<Rgb> y(matrix.rows(), Rgb::Zero());
  tbb::parallel_for(std::size_t{0}, matrix.rows(), [&](std::size_t r) {
    for (std::size_t e = r == 0 ? 0 : matrix.ends[r - 1]; e < matrix.ends[r]; ++e) {
      const float* value = &matrix.values[e * matrix.value_columns];
      y[r] += matrix.value_columns == 1 ? Rgb(*value * x[matrix.columns[e]])
                                        : Rgb(Eigen::Map<const Rgb>(value) * x[matrix.columns[e]]);
    }
  });
  return y;
}

std::vector<Rgb> multiplyTransposed(const Matrix& matrix, const std::vector<Rgb>& y, std::size_t columns) {
  std::vector<Rgb> x(columns, Rgb::Zero());
  for (std::size_t r = 0; r < matrix.rows(); ++r)
    for (std::size_t e = r == 0 ? 0 : matrix.ends[r - 1]; e < matrix.ends[r]; ++e)
      x[matrix.columns[e]] += matrix.values[e] * y[r];
  return x;
}

Matrix sharpeningOf(const Knots& knots) {
  return {knots.ring_ends, knots.rings, knots.sharpening, 1};
}

std::vector<Rgb> Throughput::respondByFarKnots(const std::vector<Rgb>& power) const {
  return multiply(spread_, multiply(far_, multiplyTransposed(spread_, power, farCount())));
}

std::vector<Rgb> Throughput::respondSmoothly(const std::vector<Rgb>& power, float radius) const {
  const PointIndex index(knots_.positions);
  const double reach = has_far_ ? static_cast<double>(outer_smoothing_) : reachOfFactors(hatArea());
  std::vector<Rgb> response =
      has_far_ ? respondByFarKnots(power) : std::vector<Rgb>(knots_.count(), Rgb::Zero());
  tbb::parallel_for(std::size_t{0}, knots_.count(), [&](std::size_t i) {
    std::vector<std::uint32_t> near;
    index.within(knots_.positions[i], reach, near);
    const std::vector<Rgb> by_way_of_far = byWayOfFar(i);
    for (const std::uint32_t j : near) {
      const Vec3 &to = knots_.positions[i], &from = knots_.positions[j];
      const auto distance = static_cast<float>((to - from).norm());
      response[i] += power[j] * (reflectance_.smoothed(distance, radius,
                                                       reflectance_.along(knots_.point(i), knots_.point(j))) -
                                 givenByFar(by_way_of_far, j, distance));
    }
  });
  return response;
}

std::vector<Rgb> Throughput::respond(const std::vector<Rgb>& power) const {
  const Matrix sharpening = kernels::sharpeningOf(knots_);
  const std::vector<Rgb> sharpened = multiplyTransposed(sharpening, power, knots_.count());
  std::vector<Rgb> response = multiply(near_, sharpened);
  if (has_far_) {
    const std::vector<Rgb> from_afar = respondByFarKnots(sharpened);
    for (std::size_t i = 0; i < response.size(); ++i) response[i] += from_afar[i];
  }
  return multiply(sharpening, response);
}

}  // namespace bakelight::kernels
