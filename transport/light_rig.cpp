#include "transport/light_rig.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "transport/cube_map.h"
#include "transport/light_backdrop.h"
#include "transport/polygon_light.h"
#include "transport/sky.h"
#include "transport/windowing.h"

namespace bakelight::transport {
namespace {

class Projector {
 public:
  explicit Projector(int order) : order_(order) {}

  ShLight operator()(const formats::EnvironmentLight& light) const {
    const std::string file = light.path.string();
    const bool lat_long = light.image.width == 2 * light.image.height;
    const ShLight unturned =
        lat_long ? projectLatLong(light.image, order_, file) : projectCubeMap(light.image, order_, file);
    return scaled(ShRotation(order_, worldFromEnvironment(light)).apply(unturned), light.intensity);
  }
  ShLight operator()(const formats::DiskLight& light) const {
    return diskLight(order_, vec3(light.direction).normalized(),
                     light.half_angle_deg * std::numbers::pi / 180, light.radiance);
  }
  ShLight operator()(const formats::PolygonLight& light) const {
    std::vector<Vec3> vertices;
    for (const Float3& vertex : light.vertices) vertices.push_back(vec3(vertex));
    static_cast<void>(PolygonOutline(vertices));  // refuses one that cannot be drawn
    return polygonLight(order_, vertices, light.radiance);
  }
  ShLight operator()(const formats::DirectionalLight& light) const {
    return directionalLight(order_, vec3(light.direction).normalized(), light.irradiance);
  }
  ShLight operator()(const formats::SkyLight& light) const { return skyLight(Sky(light), order_); }

 private:
  int order_;
};

void requireFinite(const ShLight& light, const std::string& what) {
  for (std::size_t i = 0; i < light.size(); ++i)
    for (const float value : light[i])
      if (!std::isfinite(value))
        throw badInput({"", what + ", SH coefficient " + std::to_string(i), ""}, "the light is not finite",
                       "radiance that a float can sum up", "lower its radiance or intensity");
}

// projectLight, whose errors say which light of the rig they speak of.
ShLight projectLightOf(const formats::LightRig& rig, std::size_t index, int order) {
  try {
    return projectLight(rig.distant[index], order);
  } catch (const Error& error) {
    ErrorPlace place = error.place();
    if (place.pointer.empty()) place.pointer = "/lights/" + std::to_string(index);
    throw Error(error.status(), place, error.problem(), error.expected(), error.remedy());
  }
}

// Sums over the texels of one row of one face, three colours one after the other.
std::vector<double> cubeRowSums(const formats::Image& rgb, const CubeStrip& layout, int face, int y,
                                int order) {
  const int count = coefficientCount(order);
  std::vector<double> sums(3 * static_cast<std::size_t>(count), 0.0), basis(count);
  for (int x = 0; x < layout.resolution_px; ++x) {
    const double size = layout.resolution_px;
    evaluateSh(order, directionOfCubeFace(face, (x + 0.5) / size, (y + 0.5) / size), basis);
    const double solid_angle_sr = cubeTexelSolidAngle(x, y, layout.resolution_px);
    const auto [column, row] = layout.texelAt(face, x, y);
    const float* texel = rgb.texel(column, row);
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < count; ++i) sums[c * count + i] += texel[c] * solid_angle_sr * basis[i];
  }
  return sums;
}

}  // namespace

ShLight projectLight(const formats::DistantLight& light, int order) {
  ShLight projected = std::visit(Projector(order), light);
  requireFinite(projected, "light");
  return projected;
}

RigLight distantLight(const formats::LightRig& rig, int order) {
  RigLight result;
  ShLight total(coefficientCount(order), Float3{0, 0, 0});
  for (std::size_t i = 0; i < rig.distant.size(); ++i) total = sum(total, projectLightOf(rig, i, order));
  requireFinite(total, "sum of all lights");
  const WindowedLight windowed =
      rig.windowing < 0 ? windowUntilPositive(total) : window(total, rig.windowing);
  return {windowed.light, drawBackdrop(rig), windowed.moved_energy, windowed.lambda};
}

ShLight projectCubeMap(const formats::Image& strip, int order, const std::string& file) {
  const CubeStrip layout = cubeStrip(strip, file);
  const formats::Image rgb = rgbImage(strip, file);
  const int row_count = kCubeFaces * layout.resolution_px;
  std::vector<std::vector<double>> rows(row_count);
  tbb::parallel_for(0, row_count, [&](int row) {
    rows[row] = cubeRowSums(rgb, layout, row / layout.resolution_px, row % layout.resolution_px, order);
  });

  return lightFromParts(rows, order);
}

}  // namespace bakelight::transport
