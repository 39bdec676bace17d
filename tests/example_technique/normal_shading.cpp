#include "tests/example_technique/normal_shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/example_technique/normal_reflection.h"

namespace bakelight::example {
namespace {

using transport::Float3;
using transport::Vec3;

formats::Image imageOf(const formats::PackImage& picture) {
  formats::Image image(picture.width, picture.height, picture.channels);
  image.values = picture.texels.decode();
  return image;
}

Vec3 interpolated(const std::vector<Float3>& values, const formats::Triangle& corners,
                  const transport::SurfaceHit& hit) {
  return (1.0 - hit.u - hit.v) * transport::vec3(values[corners[0]]) +
         static_cast<double>(hit.u) * transport::vec3(values[corners[1]]) +
         static_cast<double>(hit.v) * transport::vec3(values[corners[2]]);
}

// Where the ball has the normal, from −1 to 1: to the right and upwards as the eye sees it.
Eigen::Vector2d placeOnBall(const Vec3& normal, const Vec3& to_eye) {
  const Vec3 upwards = std::abs(to_eye.y()) < 0.999 ? Vec3::UnitY() : Vec3::UnitX();
  const Vec3 right = upwards.cross(to_eye).normalized();
  return {normal.dot(right), normal.dot(to_eye.cross(right))};
}

Vec3 texelAt(const formats::Image& picture, int x, int y) {
  const float* texel =
      picture.texel(std::clamp(x, 0, picture.width - 1), std::clamp(y, 0, picture.height - 1));
  return {texel[0], texel[1], texel[2]};
}

Vec3 lookUp(const formats::Image& picture, const Eigen::Vector2d& place) {
  const double x = (0.5 + 0.5 * place.x()) * picture.width - 0.5;
  const double y = (0.5 - 0.5 * place.y()) * picture.height - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  const double u = x - left, v = y - top;
  return (1 - v) * ((1 - u) * texelAt(picture, left, top) + u * texelAt(picture, left + 1, top)) +
         v * ((1 - u) * texelAt(picture, left, top + 1) + u * texelAt(picture, left + 1, top + 1));
}

}  // namespace

bool NormalShading::shades(const formats::Pack& pack) {
  return normalReflectionOf(pack) != nullptr;
}

NormalShading::NormalShading(const formats::Pack& pack) : mesh_(pack.mesh) {
  const NormalReflection* reflection = normalReflectionOf(pack);
  if (reflection == nullptr || mesh_.normals.size() != mesh_.vertexCount())
    throw std::invalid_argument("shading by normals needs a picture and a normal a vertex");
  picture_ = imageOf(reflection->picture);
}

void NormalShading::setLight(std::span<const Float3> distant, std::span<const Float3> near) {
  if (distant.empty()) throw std::invalid_argument("the light has no coefficient");
  // ∫ L y_00 = 4π · mean · y_00
  constexpr auto kMeanFromFirst = static_cast<float>(0.5 * std::numbers::inv_sqrtpi);
  for (std::size_t c = 0; c < 3; ++c)
    mean_radiance_[c] = kMeanFromFirst * (distant[0][c] + (near.empty() ? 0.0F : near[0][c]));
}

void NormalShading::radianceAt(std::span<const transport::SurfaceHit> hits,
                               std::span<Float3> radiance) const {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const formats::Triangle& corners = mesh_.triangles[hits[i].triangle];
    const Vec3 normal = interpolated(mesh_.normals, corners, hits[i]).normalized();
    const Vec3 to_eye = (eye_ - interpolated(mesh_.positions, corners, hits[i])).normalized();
    const Vec3 reflected = lookUp(picture_, placeOnBall(normal, to_eye));
    for (std::size_t c = 0; c < 3; ++c)
      radiance[i][c] = mean_radiance_[c] * static_cast<float>(reflected[static_cast<Eigen::Index>(c)]);
  }
}

transport::ShadingTechnique normalShading() {
  return {"normals", NormalShading::shades,
          [](const formats::Pack& pack) -> std::unique_ptr<transport::PackShading> {
            return std::make_unique<NormalShading>(pack);
          }};
}

}  // namespace bakelight::example
