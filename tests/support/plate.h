// A flat plate with an atlas of its own, and what kernels make of it.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "formats/image.h"
#include "tests/support/temporary_folder.h"
#include "tools/atlas/atlas.h"
#include "tools/atlas/maps/geometry_maps.h"
#include "tools/kernels/kernels.h"

namespace bakelight::tests {

// `texels` × `texels` of unit side, less a margin of 2, in the plane y = 0, seen from above; vertices about `spacing` apart in rows of near
// equilateral triangles, shaken so that nothing is regular.
inline formats::TriangleMesh plateMesh(int texels, double spacing, double height = 0) {
  const double size = texels - 4, row_height = spacing * std::numbers::sqrt3 / 2;
  const int rows = std::max(1, static_cast<int>(std::lround(size / row_height)));
  const int columns = std::max(1, static_cast<int>(std::lround(size / spacing)));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-0.2 * spacing, 0.2 * spacing);
  formats::TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      double x = size * i / columns, z = size * j / rows;
      if (i > 0 && i < columns) x += (j % 2 == 1 ? 0.25 : -0.25) * spacing + shake(random) / 2;
      if (j > 0 && j < rows) z += shake(random);
      mesh.positions.push_back({static_cast<float>(x), static_cast<float>(height), static_cast<float>(z)});
      mesh.normals.push_back({0, 1, 0});
      mesh.texcoords.push_back(
          {static_cast<float>((x + 2) / texels), static_cast<float>(1 - (z + 2) / texels)});
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
      if (j % 2 == 0) {
        mesh.triangles.push_back({a, c, b});
        mesh.triangles.push_back({b, c, d});
      } else {
        mesh.triangles.push_back({a, d, b});
        mesh.triangles.push_back({a, c, d});
      }
    }
  return mesh;
}

// The same plate in a square of `texels` + 16, cut down the middle into two charts 12 texels apart.
inline formats::TriangleMesh cutPlateMesh(int texels, double spacing) {
  constexpr int kApart = 12, kMore = 16;
  const formats::TriangleMesh whole = plateMesh(texels, spacing);
  const double side = texels + kMore;
  formats::TriangleMesh mesh;
  for (const bool right : {false, true}) {
    std::vector<std::int64_t> copy(whole.vertexCount(), -1);
    for (const formats::Triangle& t : whole.triangles) {
      const float x = whole.positions[t[0]][0] + whole.positions[t[1]][0] + whole.positions[t[2]][0];
      if ((x > 1.5F * static_cast<float>(texels - 4)) != right) continue;
      formats::Triangle copied{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = t[k];
        if (copy[v] < 0) {
          copy[v] = static_cast<std::int64_t>(mesh.vertexCount());
          const formats::Float3& p = whole.positions[v];
          mesh.positions.push_back(p);
          mesh.normals.push_back(whole.normals[v]);
          mesh.texcoords.push_back({static_cast<float>((double{p[0]} + 2 + (right ? kApart : 0)) / side),
                                    static_cast<float>(1 - (double{p[2]} + 2) / side)});
        }
        copied[k] = static_cast<std::uint32_t>(copy[v]);
      }
      mesh.triangles.push_back(copied);
    }
  }
  return mesh;
}

// A medium whose mean free path is so many texels, of three albedos.
inline formats::Medium mediumOf(double mean_free_path, double albedo = 0.95) {
  formats::Medium medium;
  for (std::size_t c = 0; c < 3; ++c) {
    const double of_color = albedo - 0.02 * static_cast<double>(c);
    medium.reduced_scattering[c] = static_cast<float>(of_color / mean_free_path);
    medium.absorption[c] = static_cast<float>((1 - of_color) / mean_free_path);
  }
  return medium;
}

inline void writeMaps(const formats::TriangleMesh& mesh, int texels, const std::filesystem::path& path,
                      int border = kernels::kBorder) {
  formats::writeExr(path, atlas::geometryMaps(atlas::atlasOf(mesh), {texels, border}, "plate"),
                    formats::ExrPrecision::kFloat);
}

inline kernels::Made kernelsOf(const formats::TriangleMesh& mesh, int texels, const formats::Medium& medium,
                               const kernels::Options& options = {}) {
  const TemporaryFolder folder;
  writeMaps(mesh, texels, folder / "maps.exr");
  return kernels::makeTranslucency(mesh, folder / "maps.exr", medium, options, stage::ProgressStyle::kNone);
}

}  // namespace bakelight::tests
