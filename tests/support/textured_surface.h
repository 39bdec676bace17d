// Meshes with what synthesis needs: normals and a field of tangents.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"
#include "tools/mesomesh/synthesis/surface_graph.h"
#include "transport/vector_types.h"

namespace bakelight::tests {

struct TexturedSurface {
  formats::TriangleMesh mesh;  // with normals
  std::vector<formats::Float3> tangents;
  std::vector<std::uint32_t> exemplars;
  formats::Float3 period = {0, 0, 0};

  mesomesh::SurfaceView view() const {
    return {mesh.positions, mesh.normals, tangents, mesh.triangles, exemplars, period, "surface"};
  }
};

// Normals by area; tangents are `axis` laid on the surface.
inline TexturedSurface texturedSurface(formats::TriangleMesh mesh,
                                       const transport::Vec3& axis = {0.15, 1, 0.1}) {
  using transport::Vec3;
  TexturedSurface surface;
  std::vector<Vec3> normals(mesh.vertexCount(), Vec3::Zero());
  const auto position = [&](std::uint32_t v) {
    return Vec3(mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
  };
  for (const formats::Triangle& t : mesh.triangles) {
    const Vec3 normal = (position(t[1]) - position(t[0])).cross(position(t[2]) - position(t[0]));
    for (const std::uint32_t v : t) normals[v] += normal;
  }
  mesh.normals.resize(mesh.vertexCount());
  surface.tangents.resize(mesh.vertexCount());
  for (std::size_t v = 0; v < normals.size(); ++v) {
    const Vec3 normal = normals[v].norm() > 0 ? Vec3(normals[v].normalized()) : Vec3::UnitY();
    mesh.normals[v] = transport::float3(normal);
    surface.tangents[v] = transport::float3(Vec3(axis - axis.dot(normal) * normal));
  }
  surface.exemplars.assign(mesh.vertexCount(), 0);
  surface.mesh = std::move(mesh);
  return surface;
}

// Vertices doubled along cuts across x, a fifth of a unit apart, as an atlas leaves them at the borders of charts.
inline TexturedSurface cut(TexturedSurface surface) {
  std::vector<std::uint32_t> copies(surface.mesh.vertexCount(), ~0U);
  for (formats::Triangle& t : surface.mesh.triangles) {
    float x = 0;
    for (const std::uint32_t v : t) x += surface.mesh.positions[v][0];
    if (std::lround(5 * x / 3) % 2 == 0) continue;
    for (std::uint32_t& v : t) {
      if (copies[v] == ~0U) {
        copies[v] = static_cast<std::uint32_t>(surface.mesh.vertexCount());
        surface.mesh.positions.push_back(surface.mesh.positions[v]);
        surface.mesh.normals.push_back(surface.mesh.normals[v]);
        surface.tangents.push_back(surface.tangents[v]);
        surface.exemplars.push_back(surface.exemplars[v]);
      }
      v = copies[v];
    }
  }
  // What is left of the vertices that were copied entirely would be doubled too.
  std::vector<std::uint32_t> renumbered(surface.mesh.vertexCount(), ~0U);
  TexturedSurface result;
  result.period = surface.period;
  for (formats::Triangle t : surface.mesh.triangles) {
    for (std::uint32_t& v : t) {
      if (renumbered[v] == ~0U) {
        renumbered[v] = static_cast<std::uint32_t>(result.mesh.vertexCount());
        result.mesh.positions.push_back(surface.mesh.positions[v]);
        result.mesh.normals.push_back(surface.mesh.normals[v]);
        result.tangents.push_back(surface.tangents[v]);
        result.exemplars.push_back(surface.exemplars[v]);
      }
      v = renumbered[v];
    }
    result.mesh.triangles.push_back(t);
  }
  return result;
}

// A square grid of vertices one unit apart in the plane y = 0, without border: it goes on at the other side.
// u points along +x, v along −z.
inline TexturedSurface flatTorus(std::uint32_t side) {
  TexturedSurface surface;
  for (std::uint32_t z = 0; z < side; ++z)
    for (std::uint32_t x = 0; x < side; ++x) {
      surface.mesh.positions.push_back({static_cast<float>(x), 0, static_cast<float>(z)});
      const std::uint32_t right = (x + 1) % side, further = (z + 1) % side;
      surface.mesh.triangles.push_back({z * side + x, further * side + x, further * side + right});
      surface.mesh.triangles.push_back({z * side + x, further * side + right, z * side + right});
    }
  surface.mesh.normals.assign(surface.mesh.vertexCount(), {0, 1, 0});
  surface.tangents.assign(surface.mesh.vertexCount(), {1, 0, 0});
  surface.exemplars.assign(surface.mesh.vertexCount(), 0);
  surface.period = {static_cast<float>(side), 0, static_cast<float>(side)};
  return surface;
}

// A sheet of equilateral triangles of side 1, `columns` × `rows` vertices in the plane y = 0.
inline TexturedSurface flatSheet(std::uint32_t columns, std::uint32_t rows) {
  TexturedSurface surface;
  const auto height = static_cast<float>(std::sqrt(0.75));
  for (std::uint32_t z = 0; z < rows; ++z)
    for (std::uint32_t x = 0; x < columns; ++x) {
      surface.mesh.positions.push_back(
          {static_cast<float>(x) + (z % 2 == 1 ? 0.5f : 0.0f), 0, height * static_cast<float>(z)});
      if (z + 1 == rows || x + 1 == columns) continue;
      const std::uint32_t a = z * columns + x, b = a + 1, c = a + columns, d = c + 1;
      if (z % 2 == 0) {
        surface.mesh.triangles.push_back({a, c, b});
        surface.mesh.triangles.push_back({b, c, d});
      } else {
        surface.mesh.triangles.push_back({a, c, d});
        surface.mesh.triangles.push_back({a, d, b});
      }
    }
  surface.mesh.normals.assign(surface.mesh.vertexCount(), {0, 1, 0});
  surface.tangents.assign(surface.mesh.vertexCount(), {1, 0, 0});
  surface.exemplars.assign(surface.mesh.vertexCount(), 0);
  return surface;
}

// Each triangle as four.
inline formats::TriangleMesh subdivided(const formats::TriangleMesh& mesh) {
  formats::TriangleMesh result;
  result.positions = mesh.positions;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [place, added] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(result.positions.size()));
    if (added) {
      formats::Float3 position;
      for (std::size_t k = 0; k < 3; ++k) position[k] = 0.5f * (mesh.positions[a][k] + mesh.positions[b][k]);
      result.positions.push_back(position);
    }
    return place->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    result.triangles.insert(result.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return result;
}

// The exemplar's first three channels (or its only one) where the coordinates are, as vertex colours.
inline formats::TriangleMesh painted(const TexturedSurface& surface, const formats::Image& image,
                                     const std::vector<formats::Float2>& coordinates) {
  formats::TriangleMesh mesh = surface.mesh;
  mesh.colors.resize(mesh.vertexCount());
  const std::size_t channels = image.channelCount();
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    // Bilinear, periodic.
    const double x = static_cast<double>(coordinates[v][0]) * image.width - 0.5;
    const double y = (1 - static_cast<double>(coordinates[v][1])) * image.height - 0.5;
    const double left = std::floor(x), top = std::floor(y);
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0;
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
          const int column = (static_cast<int>(left) + i + image.width) % image.width;
          const int row = (static_cast<int>(top) + j + image.height) % image.height;
          sum += (i == 0 ? 1 - (x - left) : x - left) * (j == 0 ? 1 - (y - top) : y - top) *
                 image.texel(column, row)[channels < 3 ? 0 : c];
        }
      mesh.colors[v][c] = static_cast<float>(std::clamp(sum, 0.0, 1.0));
    }
  }
  return mesh;
}

}  // namespace bakelight::tests
