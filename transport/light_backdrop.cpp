#include "transport/light_backdrop.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/cube_map.h"
#include "transport/lights.h"
#include "transport/polygon_light.h"
#include "transport/sky.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadiansPerDegree = kPi / 180;
constexpr int kSmallestWidth_px = 512, kLargestWidth_px = 2048;
constexpr int kShapeSubsamples = 4;  // per axis and texel

bool isLatLong(const formats::Image& image) {
  return image.width == 2 * image.height;
}

// Width of a lat-long image with as many texels along the horizon.
int horizonWidth(const formats::Image& image) {
  return isLatLong(image) ? image.width : 4 * std::min(image.width, image.height);
}

class Canvas {
 public:
  explicit Canvas(int width_px) : image_(width_px, width_px / 2, {"R", "G", "B"}) {}
  formats::Image take() { return std::move(image_); }

  // Adds radianceTowards(direction), averaged over subsamples² points of each texel.
  template <class RadianceTowards>
  void add(int subsamples, const RadianceTowards& radiance_towards) {
    tbb::parallel_for(0, image_.height, [&](int y) {
      for (int x = 0; x < image_.width; ++x) {
        Eigen::Array3d total = Eigen::Array3d::Zero();
        forSubsamples(x, y, subsamples, [&](const Vec3& direction) { total += radiance_towards(direction); });
        addTo(x, y, total / (subsamples * subsamples));
      }
    });
  }

  // Adds a shape within `reach_rad` of `axis`; its drawn solid angle is made that of the ideal shape, and
  // what falls between the subsamples becomes one texel.
  template <class Contains>
  void addShape(const Vec3& axis, double reach_rad, double solid_angle_sr, const Float3& radiance,
                const Contains& contains) {
    const std::vector<double> coverage = coverageOf(axis, reach_rad, contains);
    double drawn_sr = 0;
    for (int y = 0; y < image_.height; ++y)
      for (int x = 0; x < image_.width; ++x) drawn_sr += coverage[indexOf(x, y)] * texelSolidAngle(y);
    if (!(drawn_sr > 0)) return addPoint(axis, vec3(radiance).array() * solid_angle_sr);
    const Eigen::Array3d color = vec3(radiance).array() * (solid_angle_sr / drawn_sr);
    for (int y = 0; y < image_.height; ++y)
      for (int x = 0; x < image_.width; ++x)
        if (coverage[indexOf(x, y)] > 0) addTo(x, y, coverage[indexOf(x, y)] * color);
  }

  void addPoint(const Vec3& direction, const Eigen::Array3d& irradiance) {
    const auto [u, v] = latLongOfDirection(direction);
    const int x = std::min(static_cast<int>(u * image_.width), image_.width - 1);
    const int y = std::min(static_cast<int>(v * image_.height), image_.height - 1);
    addTo(x, y, irradiance / texelSolidAngle(y));
  }

 private:
  std::size_t indexOf(int x, int y) const { return static_cast<std::size_t>(y) * image_.width + x; }
  double texelSolidAngle(int y) const { return latLongTexelSolidAngle(y, image_.width, image_.height); }

  void addTo(int x, int y, const Eigen::Array3d& radiance) {
    for (Eigen::Index c = 0; c < 3; ++c) image_.texel(x, y)[c] += static_cast<float>(radiance[c]);
  }

  template <class Visit>
  void forSubsamples(int x, int y, int subsamples, const Visit& visit) const {
    for (int j = 0; j < subsamples; ++j)
      for (int i = 0; i < subsamples; ++i)
        visit(directionOfLatLong((x + (i + 0.5) / subsamples) / image_.width,
                                 (y + (j + 0.5) / subsamples) / image_.height));
  }

  // Share of each texel's subsamples that lie within the shape.
  template <class Contains>
  std::vector<double> coverageOf(const Vec3& axis, double reach_rad, const Contains& contains) const {
    std::vector<double> coverage(static_cast<std::size_t>(image_.width) * image_.height, 0.0);
    const double texel_rad = kPi / image_.height;
    const double nearest_cosine = std::cos(std::min(reach_rad + texel_rad, kPi));
    tbb::parallel_for(0, image_.height, [&](int y) {
      for (int x = 0; x < image_.width; ++x) {
        const Vec3 center = directionOfLatLong((x + 0.5) / image_.width, (y + 0.5) / image_.height);
        if (center.dot(axis) < nearest_cosine) continue;
        int inside = 0;
        forSubsamples(x, y, kShapeSubsamples,
                      [&](const Vec3& direction) { inside += contains(direction) ? 1 : 0; });
        coverage[indexOf(x, y)] = inside / static_cast<double>(kShapeSubsamples * kShapeSubsamples);
      }
    });
    return coverage;
  }

  formats::Image image_;
};

class Painter {
 public:
  explicit Painter(int width_px) : canvas_(width_px), width_px_(width_px) {}
  formats::Image take() { return canvas_.take(); }

  void operator()(const formats::EnvironmentLight& light) {
    const formats::Image image = rgbImage(light.image, light.path.string());
    const Eigen::Matrix3d environment_from_world = worldFromEnvironment(light).transpose();
    const bool lat_long = isLatLong(image);
    const int subsamples = (horizonWidth(image) + width_px_ - 1) / width_px_;
    canvas_.add(std::max(subsamples, 1), [&](const Vec3& direction) -> Eigen::Array3d {
      const Vec3 local = environment_from_world * direction;
      return light.intensity * vec3(lat_long ? lookUpLatLong(image, local) : lookUpCubeMap(image, local));
    });
  }

  void operator()(const formats::DiskLight& light) {
    disk(vec3(light.direction).normalized(), light.half_angle_deg * kRadiansPerDegree, light.radiance);
  }

  void operator()(const formats::PolygonLight& light) {
    std::vector<Vec3> vertices;
    for (const Float3& vertex : light.vertices) vertices.push_back(vec3(vertex));
    const PolygonOutline outline(vertices);
    canvas_.addShape(outline.axis(), kPi / 2, polygonSolidAngle(vertices), light.radiance,
                     [&](const Vec3& direction) { return outline.contains(direction); });
  }

  void operator()(const formats::DirectionalLight& light) {
    canvas_.addPoint(vec3(light.direction), vec3(light.irradiance));
  }

  void operator()(const formats::SkyLight& light) {
    const Sky sky(light);
    canvas_.add(2, [&](const Vec3& direction) { return sky.radiance(direction); });
    disk(sky.sunDirection(), kSunHalfAngle_rad, float3(sky.sunRadiance().matrix()));
  }

 private:
  void disk(const Vec3& axis, double half_angle_rad, const Float3& radiance) {
    const double half_sine = std::sin(half_angle_rad / 2), edge = std::cos(half_angle_rad);
    canvas_.addShape(axis, half_angle_rad, 4 * kPi * half_sine * half_sine, radiance,
                     [&](const Vec3& direction) { return direction.dot(axis) >= edge; });
  }

  Canvas canvas_;
  int width_px_;
};

}  // namespace

Eigen::Matrix3d worldFromEnvironment(const formats::EnvironmentLight& light) {
  return Eigen::AngleAxisd(light.yaw_deg * kRadiansPerDegree, Vec3::UnitY()).toRotationMatrix();
}

formats::Image drawBackdrop(const formats::LightRig& rig) {
  int width = kSmallestWidth_px;
  for (const formats::DistantLight& light : rig.distant)
    if (const auto* environment = std::get_if<formats::EnvironmentLight>(&light))
      width = std::max(width, horizonWidth(environment->image));
  Painter painter(std::min(width, kLargestWidth_px) / 2 * 2);
  for (const formats::DistantLight& light : rig.distant) std::visit(painter, light);
  return painter.take();
}

}  // namespace bakelight::transport
