#include "tools/kernels/fallback.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tools/kernels/reflectance.h"
#include "transport/slab.h"
#include "transport/vector_types.h"

namespace bakelight::kernels {

double meanThickness(const formats::TriangleMesh& mesh) {
  using transport::Vec3;
  const auto at = [&](std::uint32_t vertex) { return transport::vec3(mesh.positions[vertex]); };
  const Vec3 origin = at(mesh.triangles.front()[0]);
  double volume = 0, area = 0;
  for (const formats::Triangle& t : mesh.triangles) {
    const Vec3 a = at(t[0]) - origin, b = at(t[1]) - origin, c = at(t[2]) - origin;
    volume += a.dot(b.cross(c)) / 6;
    area += (b - a).cross(c - a).norm() / 2;
  }
  constexpr double kFlat = 1e-6;
  const double thickness = 4 * std::abs(volume) / std::max(area, 1e-300);
  return thickness > kFlat * std::sqrt(area) ? thickness : 0;
}

namespace {

// Of the mesh's colors, by area; of what no medium has, the nearest.
std::array<double, 3> meanReflectance(const formats::TriangleMesh& mesh) {
  std::array<double, 3> sums = {0, 0, 0};
  double whole = 0;
  for (const formats::Triangle& t : mesh.triangles) {
    const transport::Vec3 a = transport::vec3(mesh.positions[t[0]]);
    const double area =
        (transport::vec3(mesh.positions[t[1]]) - a).cross(transport::vec3(mesh.positions[t[2]]) - a).norm();
    whole += area;
    for (const std::uint32_t vertex : t)
      for (std::size_t c = 0; c < 3; ++c)
        sums[c] += area / 3 *
                   static_cast<double>(
                       std::clamp(mesh.colors[vertex][c], transport::MediumField::kLeastReflectance, 1.0F));
  }
  for (double& sum : sums) sum /= std::max(whole, 1e-300);
  return sums;
}

// Without what varies: of the mean of that.
std::array<transport::ScatteringCoefficients, 3> meanCoefficients(const formats::TriangleMesh& mesh,
                                                                  const formats::Medium& medium) {
  std::array<transport::ScatteringCoefficients, 3> colors;
  for (std::size_t c = 0; c < 3; ++c) colors[c] = coefficientsOf(medium, c);
  if (medium.reflectance != formats::ReflectanceSource::kAlbedo) return colors;
  const std::array<double, 3> means = meanReflectance(mesh);
  for (std::size_t c = 0; c < 3; ++c)
    colors[c] = transport::coefficientsOfReflectance(medium.model, std::max(means[c], 1e-6),
                                                     colors[c].extinction(), medium.eta);
  return colors;
}

}  // namespace

formats::TranslucencyFallback fallbackOf(const formats::TriangleMesh& mesh, const formats::Medium& medium) {
  formats::TranslucencyFallback fallback;
  const auto coefficients = meanCoefficients(mesh, medium);
  for (std::size_t c = 0; c < 3; ++c)
    fallback.reflectance[c] = static_cast<float>(
        std::min(transport::DiffuseReflectance(medium.model, coefficients[c]).total(), 1.0));
  const double thickness = meanThickness(mesh);
  if (thickness == 0) return fallback;

  std::array<transport::SlabTransmission, 3> slabs;
  double most = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    slabs[c] = transport::slabTransmission(coefficients[c], thickness);
    most = std::max(most, slabs[c].unabsorbed);
  }
  fallback.thickness = static_cast<float>(thickness);
  fallback.transmission = static_cast<float>(most);
  for (std::size_t c = 0; c < 3; ++c) {
    fallback.transmission_color[c] = static_cast<float>(slabs[c].unabsorbed / most);
    fallback.attenuation[c] = static_cast<float>(slabs[c].attenuation);
  }
  return fallback;
}

}  // namespace bakelight::kernels
