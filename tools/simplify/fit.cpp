#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "tools/simplify/relax.h"

namespace bakelight::simplify {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

// Pull towards the present place, as a share of a sample's weight: keeps vertices that no sample reaches.
constexpr double kStiffness = 0.05;
const double kFocus = 2;
constexpr double kMaxFocus = 30;
const double kTurnCosine = 0.8;

// A point of the original surface and where the simplified mesh passes it.
struct Sample {
  SurfacePoint foot;
  double height = 0;  // of the original above the simplified triangle, along its normal
};

std::vector<Vec3> originalPoints(const WorkingMesh& original) {
  std::vector<Vec3> points = original.positions;
  for (std::size_t t = 0; t < original.triangles.size(); ++t) {
    points.push_back((original.corner(t, 0) + original.corner(t, 1) + original.corner(t, 2)) / 3);
  }
  return points;
}

std::vector<Vec3> originalNormals(const SurfaceQuery& original) {
  const WorkingMesh& mesh = original.mesh();
  std::vector<Vec3> normals(mesh.positions.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) normals[v] += mesh.areaVector(t);
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) normals.push_back(original.triangleNormal(t));
  return normals;
}

std::vector<Vec3> vertexNormals(const WorkingMesh& mesh) {
  std::vector<Vec3> normals(mesh.positions.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) normals[v] += mesh.areaVector(t);
  }
  for (Vec3& normal : normals) normal = normal.norm() > 0 ? Vec3(normal / normal.norm()) : Vec3(Vec3::Zero());
  return normals;
}

}  // namespace

std::int64_t fit(HalfEdgeMesh& half_edges, const SurfaceQuery& original, int rounds) {
  const std::vector<Vec3> points = originalPoints(original.mesh()), point_normals = originalNormals(original);
  std::int64_t moves = 0;
  for (int round = 0; round < rounds; ++round) {
    const WorkingMesh mesh = workingMesh(half_edges);
    const std::vector<Vec3> normals = vertexNormals(mesh);
    const SurfaceQuery simplified(mesh);
    std::vector<Sample> samples(points.size());
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
      samples[i].foot = simplified.closestFacing(points[i], point_normals[i]);
      if (samples[i].foot.valid) {
        samples[i].height =
            (points[i] - samples[i].foot.position).dot(simplified.triangleNormal(samples[i].foot.triangle));
      }
    });
    double mean2 = 0;
    for (const Sample& s : samples) mean2 += s.height * s.height / static_cast<double>(samples.size());
    // Normal equations for the heights along the vertex normals.
    const auto n = static_cast<Eigen::Index>(mesh.positions.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n), diagonal = Eigen::VectorXd::Zero(n);
    const auto fixed = [&](std::uint32_t v) {
      return half_edges.status(half_edges.vertex_handle(v)).feature();
    };
    for (const Sample& s : samples) {
      if (!s.foot.valid) continue;
      const double weight = mean2 > 0 ? std::min(1 + kFocus * s.height * s.height / mean2, kMaxFocus) : 1.0;
      const Triangle& t = mesh.triangles[s.foot.triangle];
      const Vec3& normal = simplified.triangleNormal(s.foot.triangle);
      for (int i = 0; i < 3; ++i) {
        if (fixed(t[i])) continue;
        const double gi = s.foot.barycentric[i] * normal.dot(normals[t[i]]);
        right[t[i]] += weight * gi * s.height;
        diagonal[t[i]] += weight * kStiffness * s.foot.barycentric[i];
        for (int j = 0; j < 3; ++j) {
          if (fixed(t[j])) continue;
          const double gj = s.foot.barycentric[j] * normal.dot(normals[t[j]]);
          entries.emplace_back(t[i], t[j], weight * gi * gj);
        }
      }
    }
    for (Eigen::Index v = 0; v < n; ++v) entries.emplace_back(v, v, diagonal[v] > 0 ? diagonal[v] : 1.0);
    SparseMatrix matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<SparseMatrix> solver(matrix);
    if (solver.info() != Eigen::Success) break;
    const Eigen::VectorXd heights = solver.solve(right);
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
      const auto handle = half_edges.vertex_handle(v);
      const Point before = half_edges.point(handle);
      std::vector<Point> old_normals;
      for (const auto face : half_edges.vf_range(handle))
        old_normals.push_back(half_edges.calc_face_normal(face));
      half_edges.set_point(handle, before + point(heights[v] * normals[v]));
      std::size_t k = 0;
      bool turned = false;
      for (const auto face : half_edges.vf_range(handle)) {
        turned |= (half_edges.calc_face_normal(face) | old_normals[k++]) < kTurnCosine;
      }
      if (turned)
        half_edges.set_point(handle, before);
      else
        ++moves;
    }
  }
  return moves;
}

}  // namespace bakelight::simplify
