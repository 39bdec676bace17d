// Geometry maps by texel and name, counted from the lower left.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "tests/support/shapes.h"
#include "tools/atlas/maps/geometry_maps.h"

namespace bakelight::tests {

class MapReader {
 public:
  explicit MapReader(formats::Image image) : image_(std::move(image)) {}

  int side() const { return image_.width; }
  float at(const std::string& channel, int i, int j) const {
    const int index = image_.channelIndex(channel);
    if (index < 0) throw std::logic_error("no channel " + channel);
    return image_.texel(i, image_.height - 1 - j)[index];
  }
  int whole(const std::string& channel, int i, int j) const { return static_cast<int>(at(channel, i, j)); }
  int coverage(int i, int j) const { return whole("coverage", i, j); }
  Vec3 vector(const std::string& name, int i, int j) const {
    return {at(name + ".X", i, j), at(name + ".Y", i, j), at(name + ".Z", i, j)};
  }

  template <class Visit>
  void forEachTexel(const Visit& visit) const {
    for (int j = 0; j < side(); ++j)
      for (int i = 0; i < side(); ++i) visit(i, j);
  }
  int count(int coverage_code) const {
    int texels = 0;
    forEachTexel([&](int i, int j) { texels += coverage(i, j) == coverage_code; });
    return texels;
  }
  double totalArea() const {
    double sum = 0;
    forEachTexel([&](int i, int j) { sum += at("area", i, j); });
    return sum;
  }
  // What the triangle's corners say about the texel's point.
  Vec3 interpolatedPosition(const TriangleMesh& mesh, int i, int j) const {
    const formats::Triangle& t = mesh.triangles[whole("triangle", i, j)];
    const double u = at("barycentric.U", i, j), v = at("barycentric.V", i, j);
    return (1 - u - v) * vec3(mesh.positions[t[0]]) + u * vec3(mesh.positions[t[1]]) +
           v * vec3(mesh.positions[t[2]]);
  }

 private:
  formats::Image image_;
};

inline MapReader mapsOf(const TriangleMesh& mesh, int resolution, int border = 0) {
  return MapReader(atlas::geometryMaps(atlas::atlasOf(mesh), {resolution, border}, "mesh"));
}

// columns × rows quads of two triangles over (s, t) in [0, 1]², with new vertices.
template <class Place, class Texture>
void addGrid(TriangleMesh& mesh, int columns, int rows, const Place& place, const Texture& texture) {
  const auto base = static_cast<std::uint32_t>(mesh.vertexCount()),
             width = static_cast<std::uint32_t>(columns + 1);
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c <= columns; ++c) {
      const double s = static_cast<double>(c) / columns, t = static_cast<double>(r) / rows;
      mesh.positions.push_back(float3(place(s, t)));
      const Eigen::Vector2d uv = texture(s, t);
      mesh.texcoords.push_back({static_cast<float>(uv.x()), static_cast<float>(uv.y())});
    }
  for (std::uint32_t r = 0; r < static_cast<std::uint32_t>(rows); ++r)
    for (std::uint32_t c = 0; c < static_cast<std::uint32_t>(columns); ++c) {
      const std::uint32_t a = base + r * width + c;
      mesh.triangles.push_back({a, a + 1, a + width + 1});
      mesh.triangles.push_back({a, a + width + 1, a + width});
    }
}

// An icosphere's two halves side by side, each laid flat about its pole; they meet in a jagged line.
inline TriangleMesh flattenedSphere(int subdivisions) {
  const TriangleMesh sphere = icosphere(subdivisions);
  TriangleMesh mesh;
  for (const int half : {1, -1}) {
    std::map<std::uint32_t, std::uint32_t> copies;
    for (const formats::Triangle& t : sphere.triangles) {
      const double height = sphere.positions[t[0]][2] + sphere.positions[t[1]][2] + sphere.positions[t[2]][2];
      if ((height >= 0) != (half > 0)) continue;
      formats::Triangle copy;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [it, is_new] = copies.try_emplace(t[k], static_cast<std::uint32_t>(mesh.vertexCount()));
        copy[k] = it->second;
        if (!is_new) continue;
        const Vec3 p = vec3(sphere.positions[t[k]]);
        const double polar = std::acos(half * p.z()), azimuth = std::atan2(half * p.y(), p.x());
        const double radius = 0.11 * polar;
        mesh.positions.push_back(sphere.positions[t[k]]);
        mesh.normals.push_back(sphere.normals[t[k]]);
        mesh.texcoords.push_back({static_cast<float>(0.5 - half * 0.25 + radius * std::cos(azimuth)),
                                  static_cast<float>(0.5 + radius * std::sin(azimuth))});
      }
      mesh.triangles.push_back(copy);
    }
  }
  return mesh;
}

}  // namespace bakelight::tests
