// Values at vertices that, interpolated over the triangles, are nearest to samples all over them, in place of values
// sampled at the vertices (Kavan, Bargteil & Sloan 2011, "Least Squares Vertex Baking").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// A place of a triangle and the area that it stands for; none: it is not used.
struct FitSample {
  Vec3 weights = Vec3::Zero();  // barycentric, of the three corners
  double area = 0;
};

// `count` places spread over each triangle, other ones in each, that stand for equal shares of its area.
std::vector<FitSample> samplesOn(const formats::TriangleMesh& mesh, std::uint32_t triangle, int count);

// Looks for the correction δ of given values at the vertices that makes least
//   Σ area (residual − Σ_i weight_i δ_i)² + smoothness Σ_triangles |Σ_i e_i δ_i|²,
// residual = what is sampled less what the given values say there, e_i the edge opposite to corner i: the second sum is
// that of 4 area² |∇δ|², so neither scale nor shape of the triangles makes it stiff. What the given values already say
// exactly stays so to the bit, and a vertex that no sample is near keeps its value.
//
// Vertices at one place with one normal are copies along a seam and get one value; along a crease each side has its own.
class VertexFit {
 public:
  // `mesh` is kept by reference and has normals.
  VertexFit(const formats::TriangleMesh& mesh, std::size_t columns, double smoothness);

  std::size_t columns() const { return columns_; }
  // Of each vertex: the first of its copies, whose value counts.
  std::uint32_t firstCopy(std::uint32_t vertex) const { return first_copy_[vertex]; }

  // What the samples of one triangle add up to; `residuals` has a row of columns a sample. Thread-safe.
  struct Element {
    std::array<float, 6> mass{};  // of corners 00, 01, 02, 11, 12, 22
    std::vector<float> right;     // 3 × columns
  };
  Element element(std::span<const FitSample> samples, std::span<const float> residuals) const;
  // Triangles must come in their order: sums depend on it.
  void add(std::uint32_t triangle, const Element& element);

  struct Corrections {
    std::vector<float> rows;     // vertices × columns; that of a vertex stands at firstCopy(vertex)
    double squares_removed = 0;  // by how much they lessen Σ area residual², over all columns
    int iterations = 0;
  };
  // Jacobi-preconditioned conjugate gradients on blocks of columns: scaled by their diagonals, mass matrices of linear
  // elements have eigenvalues of 1/2 to 2 whatever the mesh (Wathen 1987), so it takes some 20 iterations and, unlike a
  // factorisation, no more memory than four blocks of columns. The same bytes whatever the threads.
  Corrections solve();  // once

 private:
  class Solver;

  const formats::TriangleMesh& mesh_;
  std::size_t columns_;
  double smoothness_;
  std::vector<std::uint32_t> first_copy_;
  std::vector<std::array<float, 6>> mass_;  // of each triangle
  std::vector<float> right_;                // vertices × columns
};

}  // namespace bakelight::transport
