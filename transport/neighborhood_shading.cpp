#include "transport/neighborhood_shading.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "transport/evaluator.h"
#include "transport/sh.h"

namespace bakelight::transport {
namespace {

constexpr int kReceivedOrder = 5;

std::size_t squared(int order) {
  return static_cast<std::size_t>(coefficientCount(order));
}

// A_l y_lm(normal) / π: radiosity of an open receiver per unit light coefficient.
std::vector<double> openVector(int order, const Vec3& normal) {
  const std::vector<double> factors = clampedCosineFactors(order);
  std::vector<double> vector = evaluateSh(order, normal);
  for (int l = 0; l < order; ++l)
    for (int i = l * l; i < (l + 1) * (l + 1); ++i)
      vector[static_cast<std::size_t>(i)] *= factors[static_cast<std::size_t>(l)] / std::numbers::pi;
  return vector;
}

ShLight total(std::span<const Float3> distant, std::span<const Float3> near, std::size_t size) {
  if (distant.size() < size || (!near.empty() && near.size() < size))
    throw std::invalid_argument("the light has fewer coefficients than neighborhood transfer needs");
  ShLight light(distant.begin(), distant.begin() + static_cast<std::ptrdiff_t>(size));
  for (std::size_t i = 0; i < size && !near.empty(); ++i)
    for (std::size_t c = 0; c < 3; ++c) light[i][c] += near[i][c];
  return light;
}

// The interval of an axis that a coordinate lies in, and how far along it; clamped to the ends.
struct Place {
  std::size_t interval;
  double along;
};
Place placeOn(const std::vector<float>& axis, double at) {
  const auto above = std::upper_bound(axis.begin() + 1, axis.end() - 1, static_cast<float>(at));
  const auto interval = static_cast<std::size_t>(above - axis.begin()) - 1;
  const auto low = static_cast<double>(axis[interval]), high = static_cast<double>(axis[interval + 1]);
  return {interval, std::clamp((at - low) / (high - low), 0.0, 1.0)};
}

}  // namespace

formats::TriangleMesh groundMesh(const formats::GroundTransfer& ground) {
  formats::TriangleMesh mesh;
  const auto across = static_cast<std::uint32_t>(ground.x.size());
  for (const float z : ground.z)
    for (const float x : ground.x) mesh.positions.push_back({x, ground.level, z});
  mesh.normals.assign(mesh.positions.size(), {0, 1, 0});
  for (std::uint32_t row = 0; row + 1 < ground.z.size(); ++row)
    for (std::uint32_t column = 0; column + 1 < across; ++column) {
      const std::uint32_t a = row * across + column, b = a + 1, c = a + across, d = c + 1;
      mesh.triangles.push_back({a, d, b});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

std::vector<float> groundVectors(const formats::Neighborhood& neighborhood) {
  if (!neighborhood.ground) throw std::invalid_argument("there is no ground");
  const formats::GroundTransfer& ground = *neighborhood.ground;
  const std::size_t size = squared(neighborhood.order),
                    columns = static_cast<std::size_t>(neighborhood.channels) * size;
  if (ground.vectors.rows != ground.x.size() * ground.z.size() || ground.vectors.columns != columns)
    throw std::invalid_argument("the ground's table does not fit its points");
  std::vector<float> vectors = ground.vectors.decode();
  const std::vector<double> open = openVector(neighborhood.order, Vec3::UnitY());
  for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] += static_cast<float>(open[i % size]);
  return vectors;
}

double GroundFade::opacityAt(double x, double z) const {
  const double across = (x - static_cast<double>(middle[0])) / static_cast<double>(half_size[0]);
  const double along = (z - static_cast<double>(middle[1])) / static_cast<double>(half_size[1]);
  const double t = std::clamp((std::hypot(across, along) - kFadeStart) / (1 - kFadeStart), 0.0, 1.0);
  return 1 - t * t * (3 - 2 * t);
}

GroundFade fadeOf(const formats::GroundTransfer& ground) {
  GroundFade fade;
  const std::array<const std::vector<float>*, 2> axes = {&ground.x, &ground.z};
  for (std::size_t a = 0; a < 2; ++a) {
    fade.middle[a] = (axes[a]->front() + axes[a]->back()) / 2;
    fade.half_size[a] = (axes[a]->back() - axes[a]->front()) / 2;
  }
  return fade;
}

GroundShading::GroundShading(const formats::Neighborhood& neighborhood)
    : order_(neighborhood.order),
      channels_(neighborhood.channels),
      vectors_(groundVectors(neighborhood)),
      fade_(fadeOf(*neighborhood.ground)) {
  ground_.level = neighborhood.ground->level;
  ground_.x = neighborhood.ground->x;
  ground_.z = neighborhood.ground->z;
  radiosity_.assign(ground_.x.size() * ground_.z.size(), {0, 0, 0});
}

void GroundShading::setLight(std::span<const Float3> distant, std::span<const Float3> near) {
  radiosity_ = evaluateDiffuse(vectors_, order_, total(distant, near, squared(order_)), channels_);
}

Float3 GroundShading::radiosityAt(double x, double z) const {
  const Place column = placeOn(ground_.x, x), row = placeOn(ground_.z, z);
  const std::size_t first = row.interval * ground_.x.size() + column.interval;
  const Float3 &a = radiosity_[first], &b = radiosity_[first + 1], &c = radiosity_[first + ground_.x.size()],
               &d = radiosity_[first + ground_.x.size() + 1];
  Float3 result;
  for (std::size_t i = 0; i < 3; ++i) {
    const double from = a[i], across = column.along >= row.along ? b[i] - a[i] : d[i] - c[i],
                 along = column.along >= row.along ? d[i] - b[i] : c[i] - a[i];
    result[i] = static_cast<float>(from + column.along * across + row.along * along);
  }
  return result;
}

formats::Float4 GroundShading::seen(const Vec3& eye, const Vec3& direction, const Float3& albedo) const {
  const double above = eye.y() - static_cast<double>(ground_.level);
  if (!(above > 0) || !(direction.y() < 0)) return {0, 0, 0, 0};
  const Vec3 at = eye + direction * (above / -direction.y());
  const double opacity = fade_.opacityAt(at.x(), at.z());
  if (!(opacity > 0)) return {0, 0, 0, 0};
  const Float3 radiosity = radiosityAt(at.x(), at.z());
  const auto share = static_cast<float>(opacity);
  return {share * albedo[0] * radiosity[0], share * albedo[1] * radiosity[1],
          share * albedo[2] * radiosity[2], share};
}

VolumeShading::VolumeShading(const formats::Neighborhood& neighborhood)
    : order_(neighborhood.order), channels_(neighborhood.channels) {
  if (!neighborhood.volume) throw std::invalid_argument("there is no volume");
  const formats::VolumeTransfer& volume = *neighborhood.volume;
  volume_.axes = volume.axes;
  const std::size_t points = volume.axes[0].size() * volume.axes[1].size() * volume.axes[2].size();
  if (volume.matrices.rows != points || volume.matrices.columns != formats::kReceivedCoefficients *
                                                                       static_cast<std::size_t>(channels_) *
                                                                       squared(order_))
    throw std::invalid_argument("the volume's table does not fit its points");
  matrices_ = volume.matrices.decode();
  light_.assign(formats::kReceivedCoefficients, {0, 0, 0});
  changes_.assign(points * formats::kReceivedCoefficients, {0, 0, 0});
}

void VolumeShading::setLight(std::span<const Float3> distant, std::span<const Float3> near) {
  const std::size_t size = squared(order_), matrix = formats::kReceivedCoefficients * size;
  const ShLight light = total(distant, near, size);
  for (int i = 0; i < formats::kReceivedCoefficients; ++i) {
    const auto coefficient = static_cast<std::size_t>(formats::receivedCoefficient(i));
    light_[static_cast<std::size_t>(i)] = coefficient < size ? light[coefficient] : Float3{0, 0, 0};
  }
  tbb::parallel_for(std::size_t{0}, changes_.size() / formats::kReceivedCoefficients, [&](std::size_t point) {
    for (std::size_t i = 0; i < formats::kReceivedCoefficients; ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const float* row = &matrices_[point * static_cast<std::size_t>(channels_) * matrix +
                                      (channels_ == 3 ? c * matrix : 0) + i * size];
        double sum = 0;
        for (std::size_t j = 0; j < size; ++j)
          sum += static_cast<double>(row[j]) * static_cast<double>(light[j][c]);
        changes_[point * formats::kReceivedCoefficients + i][c] = static_cast<float>(sum);
      }
  });
}

Float3 VolumeShading::radiosityAt(const Vec3& position, const Vec3& normal) const {
  const std::vector<double> open = openVector(kReceivedOrder, normal);
  std::array<double, formats::kReceivedCoefficients> lobe;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < lobe.size(); ++i) {
    lobe[i] = open[static_cast<std::size_t>(formats::receivedCoefficient(static_cast<int>(i)))];
    sum += lobe[i] * vec3(light_[i]);
  }

  std::array<Place, 3> places;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<float>& coordinates = volume_.axes[axis];
    const double at = position[static_cast<Eigen::Index>(axis)];
    const bool below =
        at<static_cast<double>(coordinates.front()), beyond = at> static_cast<double>(coordinates.back());
    if (beyond || (below && axis != 1)) return float3(sum);
    places[axis] = placeOn(coordinates, at);
  }
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    std::size_t point = 0, stride = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t upper = corner >> axis & 1U;
      weight *= upper != 0 ? places[axis].along : 1 - places[axis].along;
      point += stride * (places[axis].interval + upper);
      stride *= volume_.axes[axis].size();
    }
    for (std::size_t i = 0; i < lobe.size(); ++i)
      sum += weight * lobe[i] * vec3(changes_[point * lobe.size() + i]);
  }
  return float3(sum);
}

}  // namespace bakelight::transport
