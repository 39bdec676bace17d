#include "surface/corner_mesh.h"

#include <tbb/parallel_for.h>

#include <stdexcept>

namespace bakelight::surface {

CornerMesh::CornerMesh(const SurfaceMesh& mesh)
    : positions(mesh.positions),
      triangles(mesh.triangles),
      opposite(3 * mesh.triangles.size(), kNone),
      leaving(mesh.positions.size(), kNone),
      side_feature(3 * mesh.triangles.size(), 0),
      feature(mesh.positions.size(), 0),
      locked(mesh.positions.size(), 0),
      materials(mesh.materials) {
  const EdgeGroups edges(mesh);
  tbb::parallel_for(std::size_t{0}, edges.count(), [&](std::size_t g) {
    const auto sides = edges.group(g);
    if (sides.size() == 1) return;
    if (sides.size() > 2 || start(sides[0]) != end(sides[1]))
      throw std::logic_error("simplify: a repaired mesh is not an oriented manifold");
    join(sides[0], sides[1]);
  });
  for (Side s = 0; s < opposite.size(); ++s) {
    Side& of_vertex = leaving[start(s)];
    if (of_vertex == kNone || opposite[s] == kNone) of_vertex = s;
  }
}

bool CornerMesh::areNeighbors(std::uint32_t a, std::uint32_t b) const {
  bool found = false;
  forNeighbors(a, [&](std::uint32_t v) { found |= v == b; });
  return found;
}

void CornerMesh::settle(std::uint32_t vertex, Side side) {
  Side s = side;
  while (opposite[s] != kNone) {
    s = nextSide(opposite[s]);
    if (s == side) break;
  }
  leaving[vertex] = s;
}

void CornerMesh::flip(Side side) {
  const Side other = opposite[side];
  const std::uint32_t t = side / 3, u = other / 3;
  // a → b is the edge, c and d the apexes.
  const std::uint32_t a = start(side), b = end(side), c = apex(side), d = apex(other);
  const Side bc = opposite[nextSide(side)], ca = opposite[previousSide(side)];
  const Side ad = opposite[nextSide(other)], db = opposite[previousSide(other)];
  const std::uint8_t bc_feature = side_feature[nextSide(side)], ca_feature = side_feature[previousSide(side)];
  const std::uint8_t ad_feature = side_feature[nextSide(other)],
                     db_feature = side_feature[previousSide(other)];
  // side: d → c, c → a, a → d;  other: c → d, d → b, b → c.
  triangles[t][side % 3] = d, triangles[t][nextSide(side) % 3] = c, triangles[t][previousSide(side) % 3] = a;
  triangles[u][other % 3] = c, triangles[u][nextSide(other) % 3] = d,
                       triangles[u][previousSide(other) % 3] = b;
  join(nextSide(side), ca), join(previousSide(side), ad);
  join(nextSide(other), db), join(previousSide(other), bc);
  side_feature[nextSide(side)] = ca_feature, side_feature[previousSide(side)] = ad_feature;
  side_feature[nextSide(other)] = db_feature, side_feature[previousSide(other)] = bc_feature;
  settle(a, previousSide(side));
  settle(b, previousSide(other));
  settle(c, nextSide(side));
  settle(d, nextSide(other));
}

std::uint32_t CornerMesh::addVertex(const Vec3& place) {
  positions.push_back(Vec3(place));
  leaving.push_back(kNone);
  feature.push_back(0);
  locked.push_back(0);
  return static_cast<std::uint32_t>(positions.size() - 1);
}

std::uint32_t CornerMesh::addTriangle(const Triangle& triangle, std::uint32_t like) {
  triangles.push_back(Triangle(triangle));
  opposite.resize(opposite.size() + 3, kNone);
  side_feature.resize(side_feature.size() + 3, 0);
  if (!materials.empty()) materials.push_back(std::uint32_t{materials[like]});
  return static_cast<std::uint32_t>(triangles.size() - 1);
}

void CornerMesh::splitTriangle(std::uint32_t triangle, const Vec3& place) {
  const auto [a, b, c] = triangles[triangle];
  const std::uint32_t v = addVertex(place);
  const Side first = 3 * triangle;
  const Side bc = opposite[first + 1], ca = opposite[first + 2];
  const std::uint8_t bc_feature = side_feature[first + 1], ca_feature = side_feature[first + 2];
  const Side second = 3 * addTriangle({b, c, v}, triangle), third = 3 * addTriangle({c, a, v}, triangle);
  triangles[triangle][2] = v;
  join(second, bc), join(third, ca);
  join(first + 1, second + 2), join(second + 1, third + 2), join(third + 1, first + 2);
  side_feature[first + 1] = side_feature[first + 2] = 0;
  side_feature[second] = bc_feature, side_feature[third] = ca_feature;
  leaving[v] = first + 2;
  settle(a, first);
  settle(b, second);
  settle(c, third);
}

void CornerMesh::splitEdge(Side side, const Vec3& place) {
  const Side other = opposite[side];
  const std::uint32_t a = start(side), b = end(side), v = addVertex(place);
  const std::uint8_t edge_feature = side_feature[side];
  feature[v] = edge_feature;
  // Each old triangle keeps its part at the start of its side; a new one takes the part at the end.
  const auto halve = [&](Side s) {
    const Side to_apex = nextSide(s);
    const std::uint32_t far = end(s), apex_vertex = apex(s);
    const Side beyond = opposite[to_apex];
    const std::uint8_t beyond_feature = side_feature[to_apex];
    const Side added = 3 * addTriangle({v, far, apex_vertex}, s / 3);
    triangles[s / 3][to_apex % 3] = v;
    join(added + 1, beyond);
    join(to_apex, added + 2);
    side_feature[added] = edge_feature, side_feature[added + 1] = beyond_feature;
    side_feature[to_apex] = 0;
    return added;
  };
  const Side far = halve(side);
  if (other == kNone) {
    opposite[far] = kNone;
    settle(v, far);
  } else {
    const Side other_far = halve(other);
    join(side, other_far);
    join(other, far);
    settle(v, far);
    settle(apex(other), previousSide(other));
    settle(a, nextSide(other_far));
  }
  settle(apex(side), previousSide(side));
  settle(a, side);
  settle(b, nextSide(far));
}

std::vector<Vec3> CornerMesh::normals() const {
  std::vector<Vec3> result(triangles.size());
  tbb::parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t t) {
    const Vec3 area =
        alive(static_cast<std::uint32_t>(t)) ? areaVector(static_cast<std::uint32_t>(t)) : Vec3(Vec3::Zero());
    const double length = area.norm();
    result[t] = length > 0 ? Vec3(area / length) : Vec3(Vec3::Zero());
  });
  return result;
}

void CornerMesh::compact() {
  std::vector<std::uint32_t> new_vertex(positions.size(), kNone), new_triangle(triangles.size(), kNone);
  std::uint32_t vertices = 0, kept = 0;
  for (std::uint32_t v = 0; v < positions.size(); ++v) {
    if (leaving[v] == kNone) continue;
    positions[vertices] = Vec3(positions[v]);
    leaving[vertices] = leaving[v];
    feature[vertices] = feature[v];
    locked[vertices] = locked[v];
    new_vertex[v] = vertices++;
  }
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (alive(t)) new_triangle[t] = kept++;
  }
  const auto newSide = [&](Side s) { return s == kNone ? kNone : 3 * new_triangle[s / 3] + s % 3; };
  for (std::uint32_t t = 0; t < new_triangle.size(); ++t) {
    if (new_triangle[t] == kNone) continue;
    const std::uint32_t to = new_triangle[t];
    if (!materials.empty()) materials[to] = materials[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      triangles[to][k] = new_vertex[triangles[t][k]];
      opposite[3 * to + k] = newSide(opposite[3 * t + k]);
      side_feature[3 * to + k] = side_feature[3 * t + k];
    }
  }
  for (std::uint32_t v = 0; v < vertices; ++v) leaving[v] = newSide(leaving[v]);
  positions.resize(vertices), leaving.resize(vertices), feature.resize(vertices), locked.resize(vertices);
  triangles.resize(kept), opposite.resize(3 * std::size_t{kept}), side_feature.resize(3 * std::size_t{kept});
  if (!materials.empty()) materials.resize(kept);
}

}  // namespace bakelight::surface
