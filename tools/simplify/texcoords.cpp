#include "tools/simplify/texcoords.h"

#include <algorithm>
#include <map>
#include <utility>

#include "surface/repair.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {
namespace {

using Place = std::array<double, 3>;

Place placeOf(const Vec3& position) {
  return {position.x(), position.y(), position.z()};
}

// A triangle's places in order, and which of its corners has which.
struct PlacedTriangle {
  std::array<std::pair<Place, std::uint32_t>, 3> corners;
  std::uint32_t triangle;

  PlacedTriangle(const std::array<Vec3, 3>& positions, std::uint32_t index) : triangle(index) {
    for (std::uint32_t k = 0; k < 3; ++k) corners[k] = {placeOf(positions[k]), k};
    std::sort(corners.begin(), corners.end());
  }
  // Whether the places in order run round the triangle as its corners do.
  bool runsForward() const { return (corners[1].second + 3 - corners[0].second) % 3 == 1; }
  std::array<Place, 3> places() const { return {corners[0].first, corners[1].first, corners[2].first}; }
};

}  // namespace

std::vector<CornerTexcoords> texcoordsThroughRepair(const formats::TriangleMesh& input,
                                                    const WorkingMesh& original, double weld_tolerance,
                                                    const WorkingMesh& repaired) {
  const std::vector<std::uint32_t> welded = weldedVertices(original.positions, weld_tolerance);
  std::vector<PlacedTriangle> sources;
  for (std::uint32_t t = 0; t < original.triangles.size(); ++t) {
    const Triangle& v = original.triangles[t];
    sources.emplace_back(std::array{original.positions[welded[v[0]]], original.positions[welded[v[1]]],
                                    original.positions[welded[v[2]]]},
                         t);
  }
  std::stable_sort(sources.begin(), sources.end(),
                   [](const PlacedTriangle& a, const PlacedTriangle& b) { return a.places() < b.places(); });

  std::vector<CornerTexcoords> texcoords(repaired.triangles.size());
  for (std::uint32_t t = 0; t < texcoords.size(); ++t) {
    const PlacedTriangle wanted({repaired.corner(t, 0), repaired.corner(t, 1), repaired.corner(t, 2)}, t);
    auto source = std::lower_bound(
        sources.begin(), sources.end(), wanted,
        [](const PlacedTriangle& a, const PlacedTriangle& b) { return a.places() < b.places(); });
    if (source == sources.end() || source->places() != wanted.places()) return {};
    // On opposite sheets the one that faces the same way.
    const auto facing = std::find_if(source, sources.end(), [&](const PlacedTriangle& other) {
      return other.places() != wanted.places() || other.runsForward() == wanted.runsForward();
    });
    if (facing != sources.end() && facing->places() == wanted.places()) source = facing;
    for (std::size_t k = 0; k < 3; ++k)
      texcoords[t][wanted.corners[k].second] =
          input.texcoords[input.triangles[source->triangle][source->corners[k].second]];
  }
  return texcoords;
}

std::int64_t setTexcoords(formats::TriangleMesh& mesh, std::span<const CornerTexcoords> corners) {
  const std::size_t vertices = mesh.vertexCount();
  std::vector<std::uint8_t> is_set(vertices, 0);
  std::map<std::pair<std::uint32_t, formats::Float2>, std::uint32_t> copies;
  mesh.texcoords.assign(vertices, {0, 0});
  for (std::size_t t = 0; t < corners.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& vertex = mesh.triangles[t][k];
      const formats::Float2& texcoord = corners[t][k];
      if (!std::exchange(is_set[vertex], 1)) mesh.texcoords[vertex] = texcoord;
      if (mesh.texcoords[vertex] == texcoord) continue;
      const auto [copy, is_new] =
          copies.try_emplace({vertex, texcoord}, static_cast<std::uint32_t>(mesh.vertexCount()));
      if (is_new) {
        mesh.positions.push_back(formats::Float3(mesh.positions[vertex]));
        mesh.normals.push_back(formats::Float3(mesh.normals[vertex]));
        mesh.texcoords.push_back(texcoord);
      }
      vertex = copy->second;
    }
  return static_cast<std::int64_t>(mesh.vertexCount() - vertices);
}

}  // namespace bakelight::simplify
