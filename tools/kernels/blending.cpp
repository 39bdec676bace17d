#include "tools/kernels/blending.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <map>
#include <memory>
#include <span>

#include "formats/translucency.h"
#include "tools/kernels/point_index.h"
#include "tools/stage/stopwatch.h"

namespace bakelight::kernels {
namespace {

constexpr int kReach = formats::kKernelSide / 2;
constexpr float kHalfWindow = formats::kKernelSide / 2.0F;
// Of the square of the sum's error against the sum of squares: the sum is what shows.
constexpr double kSumWeight = 100;
// What is smooth over that many spacings, hats between knots follow.
constexpr float kRoughRadius = 2;
// What is smooth over that many, sums over knots follow.
constexpr float kExactRadius = 4;
constexpr double kRidge = 0.01;  // of the hats' squares, inside the window, too
constexpr double kRankThreshold = 1e-7;
constexpr float kMostWeight = 2;  // that a texel may give to one of its knots, of what falls on it

// Around a triangle, all that is needed to weigh its texels.
struct Neighborhood {
  std::vector<std::uint32_t> triangles;     // along the surface, ascending
  std::vector<std::uint32_t> knots;         // theirs, ascending
  std::vector<std::array<Rgb, 3>> factors;  // of each knot to the triangle's, sharpened

  std::size_t placeOf(std::uint32_t knot) const {
    return static_cast<std::size_t>(std::lower_bound(knots.begin(), knots.end(), knot) - knots.begin());
  }
};

// Of texels.
struct FitCounts {
  std::size_t rank_deficient = 0, clamped = 0;
};

class Blender {
 public:
  Blender(const Knots& knots, const Texels& texels, const Reflectance& reflectance,
          const Throughput& throughput)
      : knots_(knots), texels_(texels), reflectance_(reflectance), throughput_(throughput) {
    texels_of_.resize(knots.triangles.size());
    for (std::size_t i = 0; i < texels.count(); ++i) {
      texels_of_[texels.triangles[i]].push_back(static_cast<std::uint32_t>(i));
      bands_.push_back(reflectance.bandOf(texels.sides[i]));
    }
  }

  Blending make(const std::function<void(std::size_t)>& progress) {
    std::map<std::string, double> seconds;
    stage::Stopwatch watch(seconds);
    result_.densities.assign(texels_.count(), {Rgb::Zero(), Rgb::Zero(), Rgb::Zero()});
    neighborhoods_.resize(knots_.triangles.size());
    std::vector<FitCounts> counts(knots_.triangles.size());
    tbb::parallel_for(std::size_t{0}, knots_.triangles.size(), [&](std::size_t t) {
      if (texels_of_[t].empty()) return;
      neighborhoods_[t] = neighborhoodOf(t);
      for (const std::uint32_t texel : texels_of_[t]) fit(t, texel, counts[t]);
      progress(1);
    });
    for (const FitCounts& count : counts) {
      result_.rank_deficient += count.rank_deficient;
      result_.clamped += count.clamped;
    }
    watch.lap("fit");
    chooseReceivers();
    findMissing();
    makeKernels(progress);
    watch.lap("kernels");
    result_.fit_seconds = seconds["fit"], result_.kernel_seconds = seconds["kernels"];
    return std::move(result_);
  }

 private:
  // Whether light that falls on `source` reaches `receiver` by its kernel.
  bool inWindow(std::size_t receiver, std::size_t source) const {
    if (texels_.charts[receiver] == texels_.charts[source]) {
      const int side = texels_.resolution;
      const int a = static_cast<int>(texels_.places[receiver]), b = static_cast<int>(texels_.places[source]);
      if (std::abs(a % side - b % side) <= kReach && std::abs(a / side - b / side) <= kReach) return true;
    }
    const Eigen::Vector3f d = texels_.positions[source] - texels_.positions[receiver];
    const float cell = texels_.sides[receiver];
    if (d.squaredNorm() > 4 * kHalfWindow * kHalfWindow * cell * cell) return false;
    const Eigen::Vector3f& across = texels_.across[receiver];
    const Eigen::Vector3f& down = texels_.down[receiver];
    const float a2 = across.squaredNorm(), b2 = down.squaredNorm();
    if (a2 == 0 || b2 == 0 || texels_.charts[receiver] == texels_.charts[source]) return false;
    return std::abs(d.dot(across)) < kHalfWindow * a2 && std::abs(d.dot(down)) < kHalfWindow * b2;
  }

  Neighborhood neighborhoodOf(std::size_t t) const {
    Neighborhood near;
    const auto& corners = knots_.triangles[t];
    // Triangles with a corner in the ball in which factors are smoothed, and those that windows show.
    std::vector<std::uint32_t> along;
    for (const std::uint32_t k : corners) {
      alongSurface(knots_, k, 1.5 * static_cast<double>(throughput_.smoothing(k)), along);
      for (const std::uint32_t other : along)
        for (const std::uint32_t f : knots_.fan(other)) near.triangles.push_back(f);
    }
    std::vector<std::uint32_t> seen;
    for (const std::uint32_t texel : texels_of_[t])
      for (int dy = -kReach; dy <= kReach; ++dy)
        for (int dx = -kReach; dx <= kReach; ++dx) {
          const std::int32_t other = texels_.neighbour(texel, dx, dy);
          if (other >= 0) seen.push_back(texels_.triangles[static_cast<std::size_t>(other)]);
        }
    near.triangles.insert(near.triangles.end(), seen.begin(), seen.end());
    sortOut(near.triangles);
    for (const std::uint32_t f : near.triangles)
      near.knots.insert(near.knots.end(), knots_.triangles[f].begin(), knots_.triangles[f].end());
    sortOut(near.knots);
    near.factors = factorsTo(corners, near.knots);
    return near;
  }

  static void sortOut(std::vector<std::uint32_t>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }

  // Sharpened on both sides: by way of the knots around either.
  std::vector<std::array<Rgb, 3>> factorsTo(const std::array<std::uint32_t, 3>& corners,
                                            const std::vector<std::uint32_t>& others) const {
    std::vector<std::uint32_t> around;
    for (const std::uint32_t k : others) {
      const auto ring = knots_.ring(k);
      around.insert(around.end(), ring.begin(), ring.end());
    }
    sortOut(around);
    // First of the corners' side.
    std::vector<std::array<Rgb, 3>> half(around.size());
    for (std::size_t j = 0; j < around.size(); ++j)
      for (std::size_t c = 0; c < 3; ++c) {
        Rgb sum = Rgb::Zero();
        const auto ring = knots_.ring(corners[c]);
        const auto weights = knots_.sharpeningOf(corners[c]);
        for (std::size_t i = 0; i < ring.size(); ++i)
          sum += weights[i] * throughput_.between(ring[i], around[j]);
        half[j][c] = sum;
      }
    std::vector<std::array<Rgb, 3>> factors(others.size());
    for (std::size_t o = 0; o < others.size(); ++o) {
      const auto ring = knots_.ring(others[o]);
      const auto weights = knots_.sharpeningOf(others[o]);
      factors[o] = {Rgb::Zero(), Rgb::Zero(), Rgb::Zero()};
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const auto j = static_cast<std::size_t>(std::lower_bound(around.begin(), around.end(), ring[i]) -
                                                around.begin());
        for (std::size_t c = 0; c < 3; ++c) factors[o][c] += weights[i] * half[j][c];
      }
    }
    return factors;
  }

  // By factors alone, from a texel of the neighborhood's triangle to each of its knots, or the other way.
  std::vector<Rgb> toKnots(const Neighborhood& near, std::size_t texel) const {
    std::vector<Rgb> values(near.knots.size());
    const Eigen::Array3f& w = texels_.weights[texel];
    for (std::size_t o = 0; o < values.size(); ++o)
      values[o] = w[0] * near.factors[o][0] + w[1] * near.factors[o][1] + w[2] * near.factors[o][2];
    return values;
  }
  Rgb between(const Neighborhood& near, const std::vector<Rgb>& to_knots, std::size_t texel) const {
    const auto& corners = knots_.triangles[texels_.triangles[texel]];
    const Eigen::Array3f& w = texels_.weights[texel];
    return w[0] * to_knots[near.placeOf(corners[0])] + w[1] * to_knots[near.placeOf(corners[1])] +
           w[2] * to_knots[near.placeOf(corners[2])];
  }

  void fit(std::size_t t, std::uint32_t texel, FitCounts& counts) {
    const auto& corners = knots_.triangles[t];
    const Neighborhood& near = neighborhoods_[t];
    const std::vector<Rgb> to_knots = toKnots(near, texel);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(),
                    right = Eigen::Matrix3d::Zero();  // right: corner × color
    Eigen::Vector3d hats = Eigen::Vector3d::Zero(), missing = Eigen::Vector3d::Zero();
    double area = 0, whole = 0;
    for (const std::uint32_t f : near.triangles) {
      Eigen::Vector3i place(-1, -1, -1);
      bool under = false;
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k)
          if (knots_.triangles[f][static_cast<std::size_t>(k)] == corners[static_cast<std::size_t>(c)])
            place[c] = k, under = true;
      if (!under) continue;
      for (const std::uint32_t x : texels_of_[f]) {
        if (texels_.areas[x] == 0) continue;
        const double a = static_cast<double>(texels_.areas[x]);
        Eigen::Vector3d hat;
        for (int c = 0; c < 3; ++c)
          hat[c] = place[c] < 0 ? 0 : static_cast<double>(texels_.weights[x][place[c]]);
        whole += a * hat.squaredNorm();
        if (inWindow(x, texel)) continue;
        const float distance = (texels_.positions[x] - texels_.positions[texel]).norm();
        const Rgb rest =
            reflectance_.betweenTexels(distance, texels_.sides[x], bands_[x],
                                       reflectance_.along(texels_.point(x), texels_.point(texel))) -
            between(near, to_knots, x);
        const Eigen::Vector3d r = rest.matrix().cast<double>();
        normal += a * hat * hat.transpose();
        right += a * hat * r.transpose();
        hats += a * hat;
        missing += a * r;
        area += a;
      }
    }
    if (area == 0) {
      ++counts.rank_deficient;
      return;
    }
    // Hats that lie in the window but for their rims would have to be huge to matter outside of it.
    normal += kRidge * whole * Eigen::Matrix3d::Identity();
    normal += kSumWeight / area * hats * hats.transpose();
    right += kSumWeight / area * hats * missing.transpose();
    Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix3d> decomposition;
    decomposition.setThreshold(kRankThreshold);
    decomposition.compute(normal);
    const Eigen::Matrix3d solution = decomposition.solve(right);
    counts.rank_deficient += decomposition.rank() < 3;
    const float most = kMostWeight / std::max(texels_.cells[texel], texels_.areas[texel]);
    bool clamped = false;
    for (std::size_t c = 0; c < 3; ++c)
      for (int color = 0; color < 3; ++color) {
        const auto value = static_cast<float>(solution(static_cast<Eigen::Index>(c), color));
        clamped = clamped || !(std::abs(value) <= most);
        result_.densities[texel][c][color] = std::isnan(value) ? 0 : std::clamp(value, -most, most);
      }
    counts.clamped += clamped;
  }

  // Those that pictures look up: all that have an area, and what bilinear lookups take beside them.
  void chooseReceivers() {
    for (std::size_t i = 0; i < texels_.count(); ++i) {
      bool needed = false;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int32_t other = texels_.neighbour(i, dx, dy);
          needed = needed || (other >= 0 && texels_.areas[static_cast<std::size_t>(other)] > 0);
        }
      if (needed) result_.receivers.push_back(static_cast<std::uint32_t>(i));
    }
  }

  // R_d less what is smooth over a radius, of texels around a place.
  Rgb roughPart(const Point& place, std::span<const std::uint32_t> near, float radius) const {
    Rgb sum = Rgb::Zero();
    for (const std::uint32_t n : near) {
      const std::uint32_t s = owned_[n];
      const auto distance = static_cast<float>((places_[n] - place.position).norm());
      if (distance >= radius) continue;
      const Place way = reflectance_.along(texels_.point(s), place);
      sum += texels_.areas[s] * (reflectance_.betweenTexels(distance, texels_.sides[s], bands_[s], way) -
                                 reflectance_.smoothed(distance, radius, way));
    }
    return sum;
  }

  // Of even light: what the whole surface sends to each knot, less what factors and weights give there, and less what of it is not smooth enough for
  // hats to follow: that each texel finds for itself. R_d over texels within a radius that is beyond all smoothing, and beyond it factors that are
  // smoother still.
  void findMissing() {
    std::vector<Rgb> power(knots_.count(), Rgb::Zero()), given = power;
    for (std::size_t i = 0; i < texels_.count(); ++i) {
      if (texels_.areas[i] == 0) continue;
      owned_.push_back(static_cast<std::uint32_t>(i));
      places_.push_back(texels_.positions[i].cast<double>());
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t knot = knots_.triangles[texels_.triangles[i]][c];
        power[knot] += texels_.areas[i] * texels_.weights[i][static_cast<Eigen::Index>(c)];
        given[knot] += texels_.areas[i] * result_.densities[i][c];
      }
    }
    index_ = std::make_unique<PointIndex>(places_);
    const float outer = throughput_.outerSmoothing(), spacing = static_cast<float>(knots_.meanSpacing());
    rough_radius_ = std::min(kRoughRadius * spacing, outer);
    const float exact_radius = std::min(kExactRadius * spacing, outer);
    missing_ = throughput_.respondSmoothly(power, exact_radius);
    const std::vector<Rgb> response = throughput_.respond(power);
    tbb::parallel_for(std::size_t{0}, knots_.count(), [&](std::size_t k) {
      std::vector<std::uint32_t> near;
      index_->within(knots_.positions[k], static_cast<double>(exact_radius), near);
      missing_[k] +=
          roughPart(knots_.point(k), near, exact_radius) - roughPart(knots_.point(k), near, rough_radius_);
      missing_[k] -= response[k] + given[k];
    });
  }

  void makeKernels(const std::function<void(std::size_t)>& progress) {
    const std::size_t values = std::size_t{3} * formats::kKernelTexels;
    result_.kernels.assign(result_.receivers.size() * values, 0);
    std::vector<std::vector<std::uint32_t>> receivers_of(knots_.triangles.size());
    for (std::size_t r = 0; r < result_.receivers.size(); ++r)
      receivers_of[texels_.triangles[result_.receivers[r]]].push_back(static_cast<std::uint32_t>(r));
    std::vector<double> shares(knots_.triangles.size(), 0);
    tbb::parallel_for(std::size_t{0}, knots_.triangles.size(), [&](std::size_t t) {
      if (receivers_of[t].empty()) return;
      // All that is near any of the triangle's texels.
      Vec3 middle = Vec3::Zero();
      for (const std::uint32_t r : receivers_of[t])
        middle += texels_.positions[result_.receivers[r]].cast<double>() /
                  static_cast<double>(receivers_of[t].size());
      double reach = 0;
      for (const std::uint32_t r : receivers_of[t])
        reach = std::max(reach, (texels_.positions[result_.receivers[r]].cast<double>() - middle).norm());
      std::vector<std::uint32_t> around;
      index_->within(middle, reach + static_cast<double>(rough_radius_), around);
      for (const std::uint32_t r : receivers_of[t])
        shares[t] += makeKernel(result_.receivers[r], around, &result_.kernels[r * values]);
      progress(1);
    });
    for (const double share : shares)
      result_.window_share += share / static_cast<double>(result_.receivers.size());
  }

  // Share of the kernel in what even light gives.
  double makeKernel(std::uint32_t receiver, std::span<const std::uint32_t> around, float* kernel) const {
    const std::size_t t = texels_.triangles[receiver];
    const auto& corners = knots_.triangles[t];
    const Neighborhood& near = neighborhoods_[t];
    const std::vector<Rgb> to_knots = toKnots(near, receiver);
    const Eigen::Array3f& w = texels_.weights[receiver];

    Rgb exact_sum = Rgb::Zero(), missing = Rgb::Zero();
    std::array<Rgb, formats::kKernelTexels> exact;
    for (int dy = -kReach, i = 0; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx, ++i) {
        exact[static_cast<std::size_t>(i)].setZero();
        const std::int32_t found = texels_.neighbour(receiver, dx, dy);
        if (found < 0) continue;
        const auto s = static_cast<std::size_t>(found);
        const float distance = (texels_.positions[s] - texels_.positions[receiver]).norm();
        const Rgb value =
            texels_.cells[s] *
            reflectance_.betweenTexels(distance, texels_.sides[receiver], bands_[receiver],
                                       reflectance_.along(texels_.point(s), texels_.point(receiver)));
        exact[static_cast<std::size_t>(i)] = value;
        exact_sum += value;
        Rgb by_weights = Rgb::Zero();
        const auto& of_source = knots_.triangles[texels_.triangles[s]];
        for (std::size_t c = 0; c < 3; ++c)
          for (std::size_t k = 0; k < 3; ++k)
            if (corners[c] == of_source[k])
              by_weights += w[static_cast<Eigen::Index>(c)] * result_.densities[s][k];
        by_weights *= texels_.cells[s];
        const Rgb left = value - texels_.cells[s] * between(near, to_knots, s) - by_weights;
        Eigen::Map<Rgb>(kernel + 3 * i) = left;
        missing -= left;
      }
    // What even light gets wrong goes to the kernel.
    missing += roughPart(texels_.point(receiver), around, rough_radius_);
    for (std::size_t c = 0; c < 3; ++c) missing += w[static_cast<Eigen::Index>(c)] * missing_[corners[c]];
    for (int color = 0; color < 3; ++color) {
      if (!(exact_sum[color] > 0)) continue;
      const float raise = missing[color] / exact_sum[color];
      for (int i = 0; i < formats::kKernelTexels; ++i)
        kernel[3 * i + color] += raise * exact[static_cast<std::size_t>(i)][color];
    }
    return static_cast<double>(exact_sum.mean());
  }

  const Knots& knots_;
  const Texels& texels_;
  const Reflectance& reflectance_;
  const Throughput& throughput_;
  std::vector<std::vector<std::uint32_t>> texels_of_;  // by triangle
  std::vector<std::uint32_t> bands_;
  std::vector<Neighborhood> neighborhoods_;
  // Texels with an area.
  std::vector<std::uint32_t> owned_;
  std::vector<Vec3> places_;
  std::unique_ptr<const PointIndex> index_;
  std::vector<Rgb> missing_;  // of even light, at knots
  float rough_radius_ = 0;
  Blending result_;
};

}  // namespace

Blending blend(const Knots& knots, const Texels& texels, const Reflectance& reflectance,
               const Throughput& throughput, const std::function<void(std::size_t)>& progress) {
  return Blender(knots, texels, reflectance, throughput).make(progress);
}

}  // namespace bakelight::kernels
