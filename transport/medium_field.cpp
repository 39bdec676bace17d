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

// Between the middles of eight cells of a grid, rows of x first; at its edge those are the same.
struct GridPlace {
  std::array<int, 3> size;
  std::array<std::size_t, 3> first, second;
  std::array<float, 3> share;  // of the second

  // Of a corner by its bits: the second in x, y and z.
  std::size_t index(std::size_t corner) const {
    const auto at = [&](std::size_t axis) { return (corner >> axis) % 2 == 1 ? second[axis] : first[axis]; };
    return (at(2) * static_cast<std::size_t>(size[1]) + at(1)) * static_cast<std::size_t>(size[0]) + at(0);
  }
  float weight(std::size_t corner) const {
    float product = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
      product *= (corner >> axis) % 2 == 1 ? share[axis] : 1 - share[axis];
    return product;
  }
};

// Of a place in cells, from the least corner of the first.
GridPlace gridPlace(const std::array<int, 3>& size, const Vec3& place) {
  GridPlace result{size, {}, {}, {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double last = size[axis] - 1;
    const double at = std::clamp(place[static_cast<Eigen::Index>(axis)] - 0.5, 0.0, last);
    result.first[axis] = static_cast<std::size_t>(at);
    result.second[axis] = std::min(result.first[axis] + 1, static_cast<std::size_t>(last));
    result.share[axis] = static_cast<float>(at - static_cast<double>(result.first[axis]));
  }
  return result;
}

formats::Medium withCoefficients(formats::Medium medium) {
  medium.reflectance = formats::ReflectanceSource::kCoefficients;
  return medium;
}

Eigen::Array3f clampedReflectance(const Float3& reflectance) {
  Eigen::Array3f clamped;
  for (std::size_t c = 0; c < 3; ++c)  // what is no number stays none
    clamped[static_cast<Eigen::Index>(c)] = std::clamp(reflectance[c], MediumField::kLeastReflectance, 1.0F);
  return clamped;
}

// √(1 − α′), by which R_d falls off, is even in that power of it: near 0, where ratios count, nodes are denser, and near 1, where reflectances are the same to within a few
// hundredths, they are not rare (measured: of 0.5, 0.7 and 1 the least error).
ScatteringCoefficients evenlyBetween(const ScatteringCoefficients& first, const ScatteringCoefficients& last,
                                     double share) {
  constexpr double kPower = 0.7;
  const auto powerOf = [](const ScatteringCoefficients& c) {
    return std::pow(std::sqrt(c.absorption / c.extinction()), kPower);
  };
  const double q = std::pow((1 - share) * powerOf(first) + share * powerOf(last), 1 / kPower);
  return {first.extinction() * (1 - q) * (1 + q), first.extinction() * q * q, first.relative_ior};
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
  if (medium.reflectance == formats::ReflectanceSource::kAlbedo)
    throw std::invalid_argument("it reflects what the surface's albedo says, and there is none");
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
  const std::uint32_t nodes = levels_.empty() ? 1 : kNodes;
  for (std::uint32_t node = 0; node < nodes; ++node) {
    const auto color = [&](std::size_t c) {
      return DiffuseReflectance(medium.model, coefficients(c, shareOfNode(node)));
    };
    reflectances_.push_back({color(0), color(1), color(2)});
  }
}

MediumField::MediumField(const formats::Medium& medium, const formats::TriangleMesh& mesh,
                         const Eigen::Isometry3d& object_from_here)
    : MediumField(withCoefficients(medium), mesh.positions, object_from_here) {
  if (medium.reflectance != formats::ReflectanceSource::kAlbedo) return;
  if (mesh.colors.size() != mesh.vertexCount() || mesh.triangles.empty())
    throw std::invalid_argument("it reflects what the surface's albedo says, and there is none");
  std::vector<Eigen::Array3f> clamped;
  for (const Float3& value : mesh.colors) clamped.push_back(clampedReflectance(value));
  Eigen::Array3f least = Eigen::Array3f::Ones(), greatest = Eigen::Array3f::Zero();
  for (const formats::Triangle& t : mesh.triangles)
    for (const std::uint32_t vertex : t) {
      if (!clamped[vertex].allFinite()) throw std::invalid_argument("a reflectance is not finite");
      least = least.min(clamped[vertex]), greatest = greatest.max(clamped[vertex]);
    }
  const bool varies = (greatest > least).any();
  reflectances_.clear();
  const std::uint32_t count = varies ? kReflectanceNodes : 1;
  std::array<std::vector<DiffuseReflectance>, 3> colors;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto of = [&](float total) {
      return coefficientsOfReflectance(medium.model, static_cast<double>(total), plain_[c].extinction(),
                                       medium.eta);
    };
    const ScatteringCoefficients first = of(least[static_cast<Eigen::Index>(c)]),
                                 last = of(greatest[static_cast<Eigen::Index>(c)]);
    for (std::uint32_t n = 0; n < count; ++n) {
      const double share = count > 1 ? static_cast<double>(n) / (count - 1) : 0;
      const ScatteringCoefficients between = n == 0           ? first
                                             : n + 1 == count ? last
                                                              : evenlyBetween(first, last, share);
      colors[c].emplace_back(medium.model, between);
      color_nodes_[c].reflectances[n] = static_cast<float>(colors[c].back().total());
    }
    for (std::uint32_t bin = 0, node = 0; bin < kReflectanceBins; ++bin) {
      const float lowest = static_cast<float>(bin) / kReflectanceBins;
      while (node + 2 < count && color_nodes_[c].reflectances[node + 1] < lowest) ++node;
      color_nodes_[c].of_bin[bin] = node;
    }
  }
  for (std::uint32_t n = 0; n < count; ++n)
    reflectances_.push_back({colors[0][n], colors[1][n], colors[2][n]});
  if (varies) addUp(mesh, clamped);
}

// Sums over cells, of points that stand for pieces of triangles half as wide as a cell.
void MediumField::addUp(const formats::TriangleMesh& mesh, std::span<const Eigen::Array3f> reflectance) {
  constexpr double kCells = 128;  // along the longest side of the object
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  std::vector<Vec3> places;
  for (const Float3& position : mesh.positions) places.push_back(object_from_here_ * vec3(position));
  for (const formats::Triangle& t : mesh.triangles)
    for (const std::uint32_t vertex : t)
      low = low.cwiseMin(places[vertex]), high = high.cwiseMax(places[vertex]);
  origin_ = low;
  surface_cell_ = std::max((high - low).maxCoeff() / kCells, 1e-300);
  SurfaceLevel finest;
  for (std::size_t axis = 0; axis < 3; ++axis)
    finest.size[axis] = static_cast<int>((high - low)[static_cast<Eigen::Index>(axis)] / surface_cell_) + 1;
  finest.sums.assign(static_cast<std::size_t>(finest.size[0]) * finest.size[1] * finest.size[2],
                     Eigen::Array4f::Zero());
  const auto add = [&](const Vec3& point, const Eigen::Array4f& sums) {
    const GridPlace place = gridPlace(finest.size, (point - origin_) / surface_cell_);
    for (std::size_t corner = 0; corner < 8; ++corner)
      finest.sums[place.index(corner)] += place.weight(corner) * sums;
  };
  for (const formats::Triangle& t : mesh.triangles) {
    const Vec3 &a = places[t[0]], ab = places[t[1]] - a, ac = places[t[2]] - a;
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int pieces = std::max(1, static_cast<int>(std::ceil(2 * longest / surface_cell_)));
    const double area = ab.cross(ac).norm() / 2 / (double{1} * pieces * pieces);
    const auto piece = [&](double u, double v) {
      Eigen::Array4f sums;
      sums << static_cast<float>(1 - u - v) * reflectance[t[0]] + static_cast<float>(u) * reflectance[t[1]] +
                  static_cast<float>(v) * reflectance[t[2]],
          1;
      // In cells' areas, so that neither large nor small units lose them.
      add(a + u * ab + v * ac, static_cast<float>(area / (surface_cell_ * surface_cell_)) * sums);
    };
    for (int i = 0; i < pieces; ++i)
      for (int j = 0; i + j < pieces; ++j) {
        piece((i + 1.0 / 3) / pieces, (j + 1.0 / 3) / pieces);
        if (i + j + 1 < pieces) piece((i + 2.0 / 3) / pieces, (j + 2.0 / 3) / pieces);
      }
  }
  surface_levels_.push_back(std::move(finest));
  while (surface_levels_.size() < kScales - 1) {
    const SurfaceLevel& fine = surface_levels_.back();
    SurfaceLevel coarse;
    for (std::size_t axis = 0; axis < 3; ++axis) coarse.size[axis] = (fine.size[axis] + 1) / 2;
    coarse.sums.assign(static_cast<std::size_t>(coarse.size[0]) * coarse.size[1] * coarse.size[2],
                       Eigen::Array4f::Zero());
    std::size_t i = 0;
    for (int z = 0; z < fine.size[2]; ++z)
      for (int y = 0; y < fine.size[1]; ++y)
        for (int x = 0; x < fine.size[0]; ++x, ++i)
          coarse.sums[(static_cast<std::size_t>(z / 2) * coarse.size[1] + y / 2) * coarse.size[0] + x / 2] +=
              fine.sums[i];
    surface_levels_.push_back(std::move(coarse));
  }
}

MediumField::Surroundings MediumField::surroundings(const Vec3& point, const Float3& reflectance) const {
  Surroundings around;
  around.front() = clampedReflectance(reflectance);
  const Vec3 offset = (object_from_here_ * point - origin_) / surface_cell_;
  for (std::size_t level = 0; level < kScales - 1; ++level) {
    const SurfaceLevel& grid = surface_levels_[level];
    const GridPlace place = gridPlace(grid.size, offset / static_cast<double>(1 << level));
    Eigen::Array4f sums = Eigen::Array4f::Zero();
    for (std::size_t corner = 0; corner < 8; ++corner)
      sums += place.weight(corner) * grid.sums[place.index(corner)];
    // Off the surface there may be none.
    around[level + 1] = sums[3] > 0 ? Eigen::Array3f(sums.head<3>() / sums[3]) : around[level];
  }
  return around;
}

// Cells have half of the distance from the second scale on; what is nearer than a cell has the points' own.
MediumField::Place MediumField::along(const Surroundings& from, const Surroundings& to,
                                      double distance) const {
  const auto scale = std::clamp(std::log2(static_cast<float>(distance / surface_cell_)), 0.0F,
                                static_cast<float>(kScales - 1));
  const auto below = std::min(static_cast<std::size_t>(scale), kScales - 2);
  const float above = scale - static_cast<float>(below);
  const Eigen::Array3f low = from[below] + to[below], high = from[below + 1] + to[below + 1];
  const Eigen::Array3f mean = (low + above * (high - low)) / 2;
  Place place;
  for (std::size_t c = 0; c < 3; ++c) {
    const ColorNodes& nodes = color_nodes_[c];
    const float reflectance = mean[static_cast<Eigen::Index>(c)];
    std::uint32_t node = nodes.of_bin[std::min(static_cast<std::uint32_t>(reflectance * kReflectanceBins),
                                               kReflectanceBins - 1)];
    while (node + 2 < kReflectanceNodes && nodes.reflectances[node + 1] < reflectance) ++node;
    const float first = nodes.reflectances[node], step = nodes.reflectances[node + 1] - first;
    place.node[c] = node;
    place.share[c] = step > 0 ? std::clamp((reflectance - first) / step, 0.0F, 1.0F) : 0;
  }
  return place;
}

MediumField::Place MediumField::placeOf(double share) {
  const double at = std::sqrt(std::clamp(share, 0.0, 1.0)) * (kNodes - 1);
  const auto node = std::min(static_cast<std::uint32_t>(at), kNodes - 2);
  // Linear in the share, not in its root.
  const double low = shareOfNode(node), high = shareOfNode(node + 1);
  const auto of_second = static_cast<float>((std::clamp(share, 0.0, 1.0) - low) / (high - low));
  return {{node, node, node}, {of_second, of_second, of_second}};
}

double MediumField::reflectance(std::size_t color, double distance, const Place& place) const {
  const double first = reflectances_[place.node[color]][color](distance);
  if (place.share[color] == 0) return first;
  const double second = reflectances_[place.node[color] + 1][color](distance);
  return first + static_cast<double>(place.share[color]) * (second - first);
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
  const GridPlace place = gridPlace(grid.size, (point - origin_) / side);
  const auto &first = place.first, &second = place.second;
  const std::array<float, 3>& share = place.share;
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
