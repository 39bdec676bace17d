// Delaunay triangulation of points of the plane.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace bakelight::btf {

using PlanePoint = std::array<double, 2>;

// Triples of indices, counter-clockwise; by exact predicates, so any points will do: of equal ones the first counts. Empty
// if all lie on one line.
std::vector<std::array<int, 3>> delaunayTriangles(std::span<const PlanePoint> points);

}  // namespace bakelight::btf
