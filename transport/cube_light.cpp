#include "transport/cube_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "formats/error.h"
#include "transport/cube_map.h"
#include "transport/light_backdrop.h"
#include "transport/lights.h"
#include "transport/multiversioned.h"
#include "transport/polygon_light.h"
#include "transport/sky.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kPointsPerTexel = 24;  // along an edge

using Energies = std::vector<Eigen::Array3d>;  // radiance × solid angle, a texel

// A circle of latitude of the lights' frame, turned: base + cosine · across + sine · along.
struct Circle {
  Eigen::Vector3f base, across, along;
};

// The cube's texels that points of a circle lie in, as cubeFaceOfDirection has it.
BAKELIGHT_MULTIVERSIONED
void texelsOnCircle(const Circle& circle, const float* cosines, const float* sines, int count, int side,
                    int* texels) {
  const float bx = circle.base.x(), by = circle.base.y(), bz = circle.base.z();
  const float px = circle.across.x(), py = circle.across.y(), pz = circle.across.z();
  const float qx = circle.along.x(), qy = circle.along.y(), qz = circle.along.z();
  const float half = 0.5F * static_cast<float>(side);
  for (int i = 0; i < count; ++i) {
    const float x = bx + cosines[i] * px + sines[i] * qx;
    const float y = by + cosines[i] * py + sines[i] * qy;
    const float z = bz + cosines[i] * pz + sines[i] * qz;
    const float ax = std::abs(x), ay = std::abs(y), az = std::abs(z);
    const bool on_x = ax >= ay && ax >= az, on_y = !on_x && ay >= az;
    const float major = on_x ? x : on_y ? y : z, scale = half / std::abs(major);
    const float s = on_x ? (x < 0 ? z : -z) : on_y ? x : (z < 0 ? -x : x);
    const float t = on_y ? (y < 0 ? -z : z) : -y;
    const int face = (on_x ? 0 : on_y ? 2 : 4) + (major < 0 ? 1 : 0);
    const int column = std::min(static_cast<int>(s * scale + half), side - 1);
    const int row = std::min(static_cast<int>(t * scale + half), side - 1);
    texels[i] = (face * side + row) * side + column;
  }
}

class CubeGatherer {
 public:
  CubeGatherer(int side, const Eigen::Matrix3d& object_from_light)
      : side_(side), object_from_light_(object_from_light), energies_(texels(), Eigen::Array3d::Zero()) {}

  std::vector<Float3> radiance() const {
    std::vector<Float3> result(texels());
    for (std::size_t i = 0; i < result.size(); ++i) {
      result[i] = float3((energies_[i] / solidAngle(i)).matrix());
      for (const float value : result[i])
        if (!std::isfinite(value))
          throw badInput({"", "texel " + std::to_string(i) + " of the cube map of light", ""},
                         "the light is not finite", "radiance that a float can sum up",
                         "lower its radiance or intensity");
    }
    return result;
  }

  void operator()(const formats::EnvironmentLight& light) {
    const std::string file = light.path.string();
    const formats::Image image = rgbImage(light.image, file);
    const Eigen::Matrix3d turn = object_from_light_ * worldFromEnvironment(light);
    if (image.width == 2 * image.height) return addLatLong(image, turn, light.intensity);
    addCube(image, cubeStrip(image, file), turn, light.intensity);
  }

  void operator()(const formats::DiskLight& light) {
    addDisk(vec3(light.direction).normalized(), light.half_angle_deg * kPi / 180,
            vec3(light.radiance).array());
  }

  void operator()(const formats::PolygonLight& light) {
    std::vector<Vec3> vertices;
    for (const Float3& vertex : light.vertices) vertices.push_back(vec3(vertex));
    const PolygonOutline outline(vertices);
    std::vector<double> covered(texels(), 0.0);
    tbb::parallel_for(std::size_t{0}, texels(), [&](std::size_t texel) {
      forPoints(texel, kPointsPerTexel, [&](const Vec3& direction, double solid_angle_sr) {
        if (outline.contains(direction)) covered[texel] += solid_angle_sr;
      });
    });
    double whole = 0;
    for (const double part : covered) whole += part;
    const Eigen::Array3d energy = vec3(light.radiance).array() * polygonSolidAngle(vertices);
    if (!(whole > 0)) return addPoint(outline.axis(), energy);
    for (std::size_t i = 0; i < covered.size(); ++i) energies_[i] += energy * (covered[i] / whole);
  }

  void operator()(const formats::DirectionalLight& light) {
    addPoint(vec3(light.direction).normalized(), vec3(light.irradiance).array());
  }

  void operator()(const formats::SkyLight& light) {
    const Sky sky(light);
    constexpr int kSkyPoints = 8;  // smooth but for the horizon
    tbb::parallel_for(std::size_t{0}, texels(), [&](std::size_t texel) {
      forPoints(texel, kSkyPoints, [&](const Vec3& direction, double solid_angle_sr) {
        energies_[texel] += sky.radiance(direction) * solid_angle_sr;
      });
    });
    addDisk(sky.sunDirection(), kSunHalfAngle_rad, sky.sunRadiance());
  }

 private:
  std::size_t texels() const { return 6 * static_cast<std::size_t>(side_) * side_; }
  double solidAngle(std::size_t texel) const {
    const auto within = static_cast<int>(texel) % (side_ * side_);
    return cubeTexelSolidAngle(within % side_, within / side_, side_);
  }
  std::size_t texelOf(const Vec3& direction) const {
    const auto [face, s, t] = cubeFaceOfDirection(object_from_light_ * direction);
    return texelAt(face, s, t);
  }
  std::size_t texelAt(int face, double s, double t) const {
    const int x = std::clamp(static_cast<int>(s * side_), 0, side_ - 1),
              y = std::clamp(static_cast<int>(t * side_), 0, side_ - 1);
    return (static_cast<std::size_t>(face) * side_ + y) * side_ + x;
  }

  void addPoint(const Vec3& direction, const Eigen::Array3d& energy) {
    energies_[texelOf(direction)] += energy;
  }

  // Over points² parts of a texel: their middles in the lights' frame, and solid angles.
  template <class Visit>
  void forPoints(std::size_t texel, int points, const Visit& visit) const {
    const auto index = static_cast<int>(texel);
    const int x = index % side_, y = index / side_ % side_, face = index / (side_ * side_),
              fine = side_ * points;
    const Eigen::Matrix3d light_from_object = object_from_light_.transpose();
    for (int j = y * points; j < (y + 1) * points; ++j)
      for (int i = x * points; i < (x + 1) * points; ++i)
        visit(Vec3(light_from_object * directionOfCubeFace(face, (i + 0.5) / fine, (j + 0.5) / fine)),
              cubeTexelSolidAngle(i, j, fine));
  }

  // Points of equal solid angle along a spiral (Fibonacci) over the cap.
  void addDisk(const Vec3& axis, double half_angle_rad, const Eigen::Array3d& radiance) {
    const double half_sine = std::sin(std::min(half_angle_rad, kPi) / 2);
    if (half_angle_rad >= kPi) {
      for (std::size_t i = 0; i < energies_.size(); ++i) energies_[i] += radiance * solidAngle(i);
      return;
    }
    const double height = 2 * half_sine * half_sine, solid_angle_sr = 2 * kPi * height;
    const double dense = 6.0 * side_ * side_ * kPointsPerTexel * kPointsPerTexel;
    const auto count = static_cast<int>(std::ceil(std::max(1024.0, dense * solid_angle_sr / (4 * kPi))));
    const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
    for (int i = 0; i < count; ++i) {
      const double z = 1 - height * (i + 0.5) / count, angle = 2 * kPi * (i / std::numbers::phi);
      const double flat = std::sqrt(std::max(0.0, 1 - z * z));
      addPoint(z * axis + flat * (std::cos(angle) * x + std::sin(angle) * y),
               radiance * (solid_angle_sr / count));
    }
  }

  // Rows of an image go to so many sums in turn, whatever the threads.
  template <class Splat>
  void addRows(int rows, const Splat& splat) {
    constexpr int kParts = 16;
    std::array<Energies, kParts> parts;
    tbb::parallel_for(0, kParts, [&](int part) {
      parts[part].assign(texels(), Eigen::Array3d::Zero());
      for (int row = part; row < rows; row += kParts) splat(row, parts[part]);
    });
    for (const Energies& part : parts)
      for (std::size_t i = 0; i < part.size(); ++i) energies_[i] += part[i];
  }

  static Eigen::Array3d color(const formats::Image& image, int x, int y) {
    const float* texel = image.texel(x, y);
    return {texel[0], texel[1], texel[2]};
  }
  int pointsFor(int texels_around) const {
    return std::max(1, (4 * side_ * kPointsPerTexel + texels_around - 1) / texels_around);
  }

  // A texel's light is spread evenly over it.
  void addLatLong(const formats::Image& image, const Eigen::Matrix3d& turn, double intensity) {
    const int points = pointsFor(image.width), columns = image.width * points, rows = image.height * points;
    std::vector<float> cosines(columns), sines(columns);
    for (int i = 0; i < columns; ++i) {
      const Vec3 on_equator = directionOfLatLong(static_cast<double>(i) / columns, 0.5);
      cosines[i] = static_cast<float>(on_equator.z());
      sines[i] = static_cast<float>(on_equator.x());
    }
    addRows(image.height, [&](int row, Energies& energies) {
      std::vector<int> texels(columns);
      for (int j = row * points; j < (row + 1) * points; ++j) {
        const double share = intensity * latLongTexelSolidAngle(j, columns, rows);
        // Rows of points are shifted against each other, else their grid beats with that of the cube's texels.
        const double shift = std::fmod(j * std::numbers::phi, 1.0) / columns;
        const Vec3 first = directionOfLatLong(0.5 + shift, (j + 0.5) / rows);
        const Vec3 level(first.x(), 0, first.z()), beside(level.z(), 0, -level.x());
        texelsOnCircle({(turn * Vec3(0, first.y(), 0)).cast<float>(), (turn * level).cast<float>(),
                        (turn * beside).cast<float>()},
                       cosines.data(), sines.data(), columns, side_, texels.data());
        for (int x = 0, i = 0; x < image.width; ++x) {
          const Eigen::Array3d energy = color(image, x, row) * share;
          for (int end = i + points; i < end; ++i) energies[texels[i]] += energy;
        }
      }
    });
  }

  void addCube(const formats::Image& image, const CubeStrip& strip, const Eigen::Matrix3d& turn,
               double intensity) {
    const int resolution = strip.resolution_px, points = pointsFor(4 * resolution),
              fine = resolution * points;
    addRows(kCubeFaces * resolution, [&](int row, Energies& energies) {
      const int face = row / resolution, y = row % resolution;
      for (int j = y * points; j < (y + 1) * points; ++j)
        for (int i = 0; i < fine; ++i) {
          const auto [column, line] = strip.texelAt(face, i / points, y);
          const auto [f, s, t] =
              cubeFaceOfDirection(turn * directionOfCubeFace(face, (i + 0.5) / fine, (j + 0.5) / fine));
          energies[texelAt(f, s, t)] +=
              color(image, column, line) * (intensity * cubeTexelSolidAngle(i, j, fine));
        }
    });
  }

  int side_;
  Eigen::Matrix3d object_from_light_;
  Energies energies_;
};

}  // namespace

std::vector<Float3> cubeLight(std::span<const formats::DistantLight> lights, int side,
                              const Eigen::Matrix3d& object_from_light) {
  CubeGatherer gatherer(side, object_from_light);
  for (const formats::DistantLight& light : lights) std::visit(gatherer, light);
  return gatherer.radiance();
}

int cubeResolutionFor(int side, int resolution_px) {
  return side * std::max(1, (resolution_px + side - 1) / side);
}

void addCubeMap(const formats::Image& strip, int side, std::span<Float3> radiance) {
  const int block = strip.height / side;
  for (int face = 0; face < kCubeFaces; ++face)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int j = y * block; j < (y + 1) * block; ++j)
          for (int i = x * block; i < (x + 1) * block; ++i) {
            const float* texel = strip.texel(face * side * block + i, j);
            sum += cubeTexelSolidAngle(i, j, side * block) * Eigen::Vector3d(texel[0], texel[1], texel[2]);
          }
        sum /= cubeTexelSolidAngle(x, y, side);
        Float3& target = radiance[(static_cast<std::size_t>(face) * side + y) * side + x];
        for (std::size_t c = 0; c < 3; ++c)
          target[c] += static_cast<float>(sum[static_cast<Eigen::Index>(c)]);
      }
}

}  // namespace bakelight::transport
