#include "tools/btf/triangulation.h"

#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <algorithm>

namespace bakelight::btf {

std::vector<std::array<int, 3>> delaunayTriangles(std::span<const PlanePoint> points) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Vertices = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
  CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertices>> triangulation;
  constexpr int kNew = -1;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t before = triangulation.number_of_vertices();
    const auto vertex = triangulation.insert({points[i][0], points[i][1]});
    if (triangulation.number_of_vertices() > before) vertex->info() = kNew;
    if (vertex->info() == kNew) vertex->info() = static_cast<int>(i);
  }
  std::vector<std::array<int, 3>> triangles;
  for (auto face = triangulation.finite_faces_begin(); face != triangulation.finite_faces_end(); ++face) {
    std::array<int, 3> corners = {face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()};
    std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
    triangles.push_back(corners);
  }
  std::ranges::sort(triangles);
  return triangles;
}

}  // namespace bakelight::btf
