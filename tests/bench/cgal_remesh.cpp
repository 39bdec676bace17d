#include "cgal_remesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

namespace bakelight::tests {

CgalTiling cgalRemeshing(const formats::TriangleMesh& mesh, double vertices, unsigned iterations) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  namespace processing = CGAL::Polygon_mesh_processing;
  std::vector<Kernel::Point_3> points;
  for (const formats::Float3& p : mesh.positions) points.emplace_back(p[0], p[1], p[2]);
  std::vector<std::vector<std::size_t>> polygons;
  for (const formats::Triangle& t : mesh.triangles) polygons.push_back({t[0], t[1], t[2]});
  processing::orient_polygon_soup(points, polygons);
  Mesh surface;
  processing::polygon_soup_to_polygon_mesh(points, polygons, surface);

  const double area = processing::area(surface);
  const double length = std::sqrt(2 * area / (std::numbers::sqrt3 * vertices));
  const auto start = std::chrono::steady_clock::now();
  processing::isotropic_remeshing(faces(surface), length, surface,
                                  CGAL::parameters::number_of_iterations(iterations));
  CgalTiling tiling;
  tiling.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  surface.collect_garbage();
  double sum = 0;
  for (const Mesh::Face_index face : surface.faces()) {
    const auto side = surface.halfedge(face);
    const Kernel::Point_3& a = surface.point(surface.source(side));
    const Kernel::Point_3& b = surface.point(surface.target(side));
    const Kernel::Point_3& c = surface.point(surface.target(surface.next(side)));
    const double sides2 =
        CGAL::squared_distance(a, b) + CGAL::squared_distance(b, c) + CGAL::squared_distance(c, a);
    sum += 4 * std::numbers::sqrt3 * std::sqrt(CGAL::squared_area(a, b, c)) / sides2;
  }
  tiling.vertices = static_cast<double>(surface.number_of_vertices());
  tiling.mean_quality = sum / static_cast<double>(surface.number_of_faces());
  return tiling;
}

}  // namespace bakelight::tests
