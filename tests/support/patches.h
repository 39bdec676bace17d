// Patches of meso-structure made by code.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "formats/image.h"
#include "patch/height_field.h"
#include "patch/mesh_patch.h"
#include "patch/patch_geometry.h"

namespace bakelight::tests {

inline formats::Image heightsOf(int width, int height,
                                const std::function<double(double, double)>& height_at) {
  formats::Image image(width, height, {"Y"});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.texel(x, y)[0] = static_cast<float>(height_at((x + 0.5) / width, 1 - (y + 0.5) / height));
  return image;
}

inline patch::PatchGeometry heightPatch(int side, double depth,
                                        const std::function<double(double, double)>& height_at,
                                        const formats::Float3& albedo = {1, 1, 1}) {
  patch::PatchGeometry geometry =
      patch::heightField(heightsOf(side, side, height_at), depth, true, "heights");
  geometry.albedo = albedo;
  return geometry;
}

inline patch::PatchGeometry flatPatch(const formats::Float3& albedo) {
  return heightPatch(
      4, 1, [](double, double) { return 0.5; }, albedo);
}

// Waves without any symmetry, 0–1.
inline double waves(double x, double y) {
  constexpr double kTurn = 2 * std::numbers::pi;
  return 0.5 + 0.2 * std::sin(kTurn * (x + 0.1)) * std::cos(kTurn * (y - 0.2)) +
         0.15 * std::sin(kTurn * (2 * x - y + 0.3)) + 0.1 * std::cos(kTurn * (x + 3 * y + 0.7));
}

// A plate, one wide, with a hole in its middle under which lies the inside of a sphere that is cut off at the plate: of
// its area the share `open` (below 1) is missing there.
inline patch::PatchGeometry dimple(double open, double hole_radius, int around,
                                   const formats::Float3& albedo) {
  constexpr double kPi = std::numbers::pi;
  const double rim = std::acos(1 - 2 * open), radius = hole_radius / std::sin(rim);
  formats::TriangleMesh mesh;
  const int rings = around / 2;
  const auto add = [&](double x, double y, double z) {
    mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  };
  const auto stripTo = [&](std::uint32_t outer, std::uint32_t inner) {  // rings of `around` vertices
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(around); ++i) {
      const std::uint32_t next = (i + 1) % static_cast<std::uint32_t>(around);
      mesh.triangles.push_back({outer + i, outer + next, inner + next});
      mesh.triangles.push_back({outer + i, inner + next, inner + i});
    }
  };
  // The plate, from the square's border to the rim.
  for (int k = 0; k <= 4; ++k)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * kPi * (i + 0.5) / around, c = std::cos(angle), s = std::sin(angle);
      const double border = 0.5 / std::max(std::abs(c), std::abs(s));
      const double r = border + (hole_radius - border) * k / 4;
      add(0.5 + r * c, 0.5 + r * s, 0);
    }
  // Corners of the square, which the border's points beside them leave out.
  const auto first_corner = static_cast<std::uint32_t>(mesh.positions.size());
  for (int k = 0; k < 4; ++k) add(k == 0 || k == 3 ? 1 : 0, k < 2 ? 1 : 0, 0);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const auto n = static_cast<std::uint32_t>(around), before = n / 8 + k * n / 4 - 1;
    mesh.triangles.push_back({before, first_corner + k, (before + 1) % n});
  }
  for (std::uint32_t k = 0; k < 4; ++k) stripTo(k * around, (k + 1) * around);
  // The sphere, from its rim down.
  std::uint32_t above = 4 * static_cast<std::uint32_t>(around);
  for (int k = 1; k < rings; ++k) {
    const double polar = rim + (kPi - rim) * k / rings;
    const auto ring = static_cast<std::uint32_t>(mesh.positions.size());
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * kPi * (i + 0.5) / around;
      add(0.5 + radius * std::sin(polar) * std::cos(angle), 0.5 + radius * std::sin(polar) * std::sin(angle),
          radius * (std::cos(polar) - std::cos(rim)));
    }
    stripTo(above, ring);
    above = ring;
  }
  const auto bottom = static_cast<std::uint32_t>(mesh.positions.size());
  add(0.5, 0.5, -radius * (1 + std::cos(rim)));
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(around); ++i)
    mesh.triangles.push_back({above + i, above + (i + 1) % static_cast<std::uint32_t>(around), bottom});
  formats::PatchMesh settings;
  settings.period = {1, 1};
  patch::PatchGeometry geometry = patch::meshPatch(mesh, settings, true, "dimple");
  geometry.albedo = albedo;
  return geometry;
}

}  // namespace bakelight::tests
