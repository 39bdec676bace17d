#include "tools/mesomesh/synthesis/mesh_vertices.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "formats/error.h"

namespace bakelight::mesomesh {
namespace {

using formats::Float3;

float dot(const Float3& a, const Float3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Float3 cross(const Float3& a, const Float3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
bool isFinite(const Float3& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

Float3 normalized(const Float3& a) {
  // By the largest entry first: squares of 1e29 or 1e-29 leave the range of floats.
  const float largest = std::max({std::abs(a[0]), std::abs(a[1]), std::abs(a[2])});
  if (!(largest > 0)) return {0, 0, 0};
  const Float3 scaled = {a[0] / largest, a[1] / largest, a[2] / largest};
  const float length = std::sqrt(dot(scaled, scaled));
  return {scaled[0] / length, scaled[1] / length, scaled[2] / length};
}

void checkLengths(const SurfaceView& surface) {
  const std::size_t count = surface.positions.size();
  if (count > std::numeric_limits<std::uint32_t>::max() / 4)
    throw badInput({surface.name, "", ""}, std::to_string(count) + " vertices are too many for synthesis");
  const auto checkLength = [&](std::size_t length, const char* what) {
    if (length != count)
      throw badInput(
          {surface.name, "", ""},
          "it has " + std::to_string(count) + " vertices and " + std::to_string(length) + " " + what,
          "one a vertex");
  };
  checkLength(surface.normals.size(), "normals");
  checkLength(surface.tangents.size(), "tangents");
  checkLength(surface.exemplars.size(), "numbers of exemplars");
}

void checkValues(const SurfaceView& surface, std::size_t exemplar_count) {
  const std::size_t count = surface.positions.size();
  for (std::size_t v = 0; v < count; ++v) {
    const auto place = [&] { return ErrorPlace{surface.name, "vertex " + std::to_string(v), ""}; };
    if (!isFinite(surface.positions[v])) throw badInput(place(), "its position is not finite");
    if (!isFinite(surface.normals[v]) || surface.normals[v] == Float3{0, 0, 0})
      throw badInput(place(), "its normal has no direction", "a direction away from the surface");
    if (!isFinite(surface.tangents[v])) throw badInput(place(), "its tangent is not finite");
    if (surface.exemplars[v] >= exemplar_count)
      throw badInput(place(), "it takes exemplar " + std::to_string(surface.exemplars[v]) + " of " +
                                  std::to_string(exemplar_count));
  }
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::uint32_t v : surface.triangles[t])
      if (v >= count)
        throw badInput({surface.name, "triangle " + std::to_string(t), ""},
                       "its vertex " + std::to_string(v) + " does not exist",
                       "a number below " + std::to_string(count));
}

SurfaceFrame frameOf(const SurfaceView& surface, std::size_t v) {
  SurfaceFrame frame{surface.positions[v], {}, {}, normalized(surface.normals[v])};
  const auto alongSurface = [&](const Float3& direction) {
    const float along_normal = dot(direction, frame.normal);
    return Float3{direction[0] - along_normal * frame.normal[0],
                  direction[1] - along_normal * frame.normal[1],
                  direction[2] - along_normal * frame.normal[2]};
  };
  Float3 tangent = alongSurface(normalized(surface.tangents[v]));
  if (dot(tangent, tangent) < 1e-8f) {
    const std::size_t least = static_cast<std::size_t>(
        std::min_element(frame.normal.begin(), frame.normal.end(),
                         [](float a, float b) { return std::abs(a) < std::abs(b); }) -
        frame.normal.begin());
    Float3 axis = {0, 0, 0};
    axis[least] = 1;
    tangent = alongSurface(axis);
  }
  frame.tangent = normalized(tangent);
  frame.bitangent = cross(frame.normal, frame.tangent);
  return frame;
}

// Every third bit of the result holds a bit of `value` (21 of them).
std::uint64_t spread(std::uint64_t value) {
  value = (value | value << 32) & 0x1f00000000ffff;
  value = (value | value << 16) & 0x1f0000ff0000ff;
  value = (value | value << 8) & 0x100f00f00f00f00f;
  value = (value | value << 4) & 0x10c30c30c30c30c3;
  return (value | value << 2) & 0x1249249249249249;
}

struct Place {
  std::uint64_t code;
  std::uint32_t vertex;
};

// Along a Morton curve; vertices at exactly one place follow each other.
std::vector<Place> orderedPlaces(const SurfaceView& surface) {
  const std::size_t count = surface.positions.size();
  Float3 least = surface.positions[0], most = least;
  for (const Float3& p : surface.positions)
    for (std::size_t k = 0; k < 3; ++k)
      least[k] = std::min(least[k], p[k]), most[k] = std::max(most[k], p[k]);
  double extent = 0;
  for (std::size_t k = 0; k < 3; ++k) extent = std::max(extent, static_cast<double>(most[k]) - least[k]);
  const double scale = extent > 0 ? ((1 << 21) - 1) / extent : 0;
  std::vector<Place> places(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t v) {
    std::uint64_t code = 0;
    for (std::size_t k = 0; k < 3; ++k)
      code |= spread(static_cast<std::uint64_t>((static_cast<double>(surface.positions[v][k]) - least[k]) *
                                                scale))
              << k;
    places[v] = {code, static_cast<std::uint32_t>(v)};
  });
  tbb::parallel_sort(places.begin(), places.end(), [&](const Place& a, const Place& b) {
    if (a.code != b.code) return a.code < b.code;
    const Float3 &p = surface.positions[a.vertex], &q = surface.positions[b.vertex];
    return std::tie(p, a.vertex) < std::tie(q, b.vertex);
  });
  return places;
}

}  // namespace

MeshVertices meshVertices(const SurfaceView& surface, std::size_t exemplar_count) {
  checkLengths(surface);
  checkValues(surface, exemplar_count);
  MeshVertices result;
  const std::size_t count = surface.positions.size();
  result.vertex_of.resize(count);
  if (count == 0) return result;
  const std::vector<Place> places = orderedPlaces(surface);
  std::vector<std::uint32_t> source;  // of each vertex, the first of the mesh's
  // Which of the vertices at this place agrees; at most six cannot agree with each other.
  std::size_t first_here = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t v = places[i].vertex;
    if (i == 0 || surface.positions[v] != surface.positions[places[i - 1].vertex]) first_here = source.size();
    std::size_t same = first_here;
    const auto agrees = [&](std::uint32_t other) {
      return surface.exemplars[other] == surface.exemplars[v] &&
             dot(normalized(surface.normals[other]), normalized(surface.normals[v])) > 0;
    };
    while (same < source.size() && !agrees(source[same])) ++same;
    if (same == source.size()) {
      source.push_back(v);
      result.on_seam.push_back(source.size() - first_here > 1 ? 1 : 0);
      if (result.on_seam.back() != 0) result.on_seam[first_here] = 1;
    } else {
      result.on_seam[same] = 1;
    }
    result.vertex_of[v] = static_cast<std::uint32_t>(same);
  }
  result.frames.resize(source.size());
  result.exemplars.resize(source.size());
  tbb::parallel_for(std::size_t{0}, source.size(), [&](std::size_t s) {
    result.frames[s] = frameOf(surface, source[s]);
    result.exemplars[s] = surface.exemplars[source[s]];
  });
  return result;
}

}  // namespace bakelight::mesomesh
