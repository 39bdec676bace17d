#include "transport/medium_field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/noise.hpp>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>

namespace bakelight::transport {
namespace {

constexpr int kOctaves = 4;
constexpr double kCellsAcross = 3;  // a vein
constexpr int kMostLevels = 8;
constexpr int kAlign = 4;    // cells that the finest level begins at a multiple of
constexpr int kSamples = 2;  // of a way
// Root mean square of the noise's slope where it is 0, per unit of its coarsest octave; measured.
constexpr double kSlope = 2.76;

// Octaves of half the size have half the height.
double noise(const Vec3& place) {
  double sum = 0, scale = 1;
  for (int octave = 0; octave < kOctaves; ++octave, scale *= 2) {
    const Vec3 p = scale * place + Vec3::Constant(17.31 * octave);
    sum += static_cast<double>(glm::perlin(
               glm::vec3(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())))) /
           scale;
  }
  return sum;
}

std::array<ScatteringCoefficients, 3> coefficientsOf(const Float3& scattering, const Float3& absorption,
                                                     const formats::Medium& medium) {
  std::array<ScatteringCoefficients, 3> colors;
  for (std::size_t c = 0; c < 3; ++c)
    colors[c] = {scattering[c] * medium.unit_mm, absorption[c] * medium.unit_mm, medium.eta};
  return colors;
}

// Nodes are denser where little changes much: absorption of a thousandth shows.
double shareOfNode(std::uint32_t node) {
  const double root = static_cast<double>(node) / (MediumField::kNodes - 1);
  return root * root;
}

}  // namespace

MediumField::MediumField(const formats::Medium& medium, std::span<const Float3> positions,
                         const Eigen::Isometry3d& object_from_here)
    : object_from_here_(object_from_here),
      plain_(coefficientsOf(medium.reduced_scattering, medium.absorption, medium)),
      veined_(plain_),
      cell_(std::numeric_limits<double>::infinity()),
      origin_(Vec3::Zero()) {
  if (medium.veins && !positions.empty()) {
    const formats::Veins& veins = *medium.veins;
    veined_ = coefficientsOf(veins.reduced_scattering, veins.absorption, medium);
    Vec3 low = object_from_here_ * vec3(positions.front()), high = low;
    for (const Float3& position : positions) {
      const Vec3 place = object_from_here_ * vec3(position);
      low = low.cwiseMin(place), high = high.cwiseMax(place);
    }
    cell_ = veins.width / kCellsAcross;
    // Aligned, so that meshes that differ a little see the same cells.
    Level finest;
    double cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double step = cell_ * kAlign, first = std::floor(low[axis] / step);
      const double count = std::floor(high[axis] / cell_) - first * kAlign + 1;
      origin_[axis] = first * step;
      cells *= count;
      if (cells <= static_cast<double>(kMostCells))
        finest.size[static_cast<std::size_t>(axis)] = static_cast<int>(count);
    }
    if (!(cells <= static_cast<double>(kMostCells)))
      throw std::invalid_argument("veins are " + std::to_string(veins.width) + " wide, and the object " +
                                  std::to_string((high - low).maxCoeff()) +
                                  ": too thin for their cells, some 1/100 of the object is about the least");
    std::mt19937 random(static_cast<unsigned>(veins.seed));
    Vec3 shift;
    for (int axis = 0; axis < 3; ++axis) shift[axis] = static_cast<double>(random() % 4096) / 16;
    const auto [width, depth, height] = std::array{finest.size[0], finest.size[1], finest.size[2]};
    finest.shares.resize(static_cast<std::size_t>(width) * depth * height);
    const double slope = kSlope / veins.spacing;
    tbb::parallel_for(0, height, [&, width = width, depth = depth](int z) {
      auto* share = &finest.shares[static_cast<std::size_t>(z) * depth * width];
      for (int y = 0; y < depth; ++y)
        for (int x = 0; x < width; ++x) {
          const Vec3 middle = origin_ + cell_ * Vec3(x + 0.5, y + 0.5, z + 0.5);
          const double distance = std::abs(noise(middle / veins.spacing + shift)) / slope;
          const double halves = distance / (veins.width / 2);
          *share++ = static_cast<float>(std::exp2(-halves * halves));
        }
    });
    levels_.push_back(std::move(finest));
    while (static_cast<int>(levels_.size()) < kMostLevels) {
      const Level& fine = levels_.back();
      Level coarse;
      for (std::size_t axis = 0; axis < 3; ++axis) coarse.size[axis] = (fine.size[axis] + 1) / 2;
      coarse.shares.resize(static_cast<std::size_t>(coarse.size[0]) * coarse.size[1] * coarse.size[2]);
      for (int z = 0, i = 0; z < coarse.size[2]; ++z)
        for (int y = 0; y < coarse.size[1]; ++y)
          for (int x = 0; x < coarse.size[0]; ++x, ++i) {
            float sum = 0;
            for (int k = 0; k < 8; ++k) {  // the last of an odd number twice
              const int fx = std::min(2 * x + (k & 1), fine.size[0] - 1),
                        fy = std::min(2 * y + ((k >> 1) & 1), fine.size[1] - 1),
                        fz = std::min(2 * z + (k >> 2), fine.size[2] - 1);
              sum += fine.shares[(static_cast<std::size_t>(fz) * fine.size[1] + fy) * fine.size[0] + fx];
            }
            coarse.shares[static_cast<std::size_t>(i)] = sum / 8;
          }
      levels_.push_back(std::move(coarse));
    }
  }
  const std::uint32_t nodes = isUniform() ? 1 : kNodes;
  for (std::uint32_t node = 0; node < nodes; ++node) {
    const auto color = [&](std::size_t c) {
      return DiffuseReflectance(medium.model, coefficients(c, shareOfNode(node)));
    };
    reflectances_.push_back({color(0), color(1), color(2)});
  }
}

MediumField::Place MediumField::placeOf(double share) {
  const double at = std::sqrt(std::clamp(share, 0.0, 1.0)) * (kNodes - 1);
  const auto node = std::min(static_cast<std::uint32_t>(at), kNodes - 2);
  // Linear in the share, not in its root.
  const double low = shareOfNode(node), high = shareOfNode(node + 1);
  return {node, static_cast<float>((std::clamp(share, 0.0, 1.0) - low) / (high - low))};
}

double MediumField::reflectance(std::size_t color, double distance, const Place& place) const {
  const double first = reflectances_[place.node][color](distance);
  if (place.share == 0) return first;
  const double second = reflectances_[place.node + 1][color](distance);
  return first + static_cast<double>(place.share) * (second - first);
}

ScatteringCoefficients MediumField::coefficients(std::size_t color, double share) const {
  const ScatteringCoefficients &a = plain_[color], &b = veined_[color];
  return {a.reduced_scattering + share * (b.reduced_scattering - a.reduced_scattering),
          a.absorption + share * (b.absorption - a.absorption), a.relative_ior};
}

// Linear between the middles of cells.
double MediumField::sample(std::size_t level, const Vec3& point) const {
  const Level& grid = levels_[level];
  const double side = cell_ * static_cast<double>(1 << level);
  std::array<std::size_t, 3> first{}, second{};
  std::array<float, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double last = grid.size[axis] - 1;
    const double at = std::clamp((point[a] - origin_[a]) / side - 0.5, 0.0, last);
    first[axis] = static_cast<std::size_t>(at);
    second[axis] = std::min(first[axis] + 1, static_cast<std::size_t>(last));
    share[axis] = static_cast<float>(at - static_cast<double>(first[axis]));
  }
  const auto width = static_cast<std::size_t>(grid.size[0]), depth = static_cast<std::size_t>(grid.size[1]);
  const auto row = [&](std::size_t y, std::size_t z) {
    const float* values = &grid.shares[(z * depth + y) * width];
    return values[first[0]] + share[0] * (values[second[0]] - values[first[0]]);
  };
  const auto plane = [&](std::size_t z) {
    const float a = row(first[1], z);
    return a + share[1] * (row(second[1], z) - a);
  };
  const float a = plane(first[2]);
  return static_cast<double>(a + share[2] * (plane(second[2]) - a));
}

double MediumField::shareAt(const Vec3& point) const {
  return isUniform() ? 0 : sample(0, object_from_here_ * point);
}

double MediumField::shareAlong(const Vec3& here, const Vec3& there) const {
  const Vec3 from = object_from_here_ * here, way = object_from_here_ * there - from;
  const double step = way.norm() / kSamples;
  if (step * kSamples < cell_) return sample(0, from + way / 2);
  const double level = std::clamp(std::log2(step / cell_), 0.0, static_cast<double>(levels_.size() - 1));
  const auto below = std::min(static_cast<std::size_t>(level), levels_.size() - 2);
  const double above = level - static_cast<double>(below);
  double sum = 0;
  for (int k = 0; k < kSamples; ++k) {
    const Vec3 point = from + (k + 0.5) / kSamples * way;
    sum += (1 - above) * sample(below, point);
    if (above > 0) sum += above * sample(below + 1, point);
  }
  return sum / kSamples;
}

}  // namespace bakelight::transport
