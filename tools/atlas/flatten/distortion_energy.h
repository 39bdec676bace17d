// How far a flat chart is from an isometry, and the way downhill.
#pragma once

#include <Eigen/SparseCore>

#include <array>
#include <cstdint>
#include <vector>

#include "tools/atlas/charts/chart.h"
#include "tools/atlas/flatten/pair_laplacian.h"

namespace bakelight::atlas {

struct RestTriangle {
  double area;
  std::array<Vec2, 3> gradients;  // of the hat functions, in the triangle's own plane
};
std::vector<RestTriangle> restTriangles(const Chart& chart);

// The symmetric Dirichlet energy Σ area · (σ₁² + σ₂² + 1/σ₁² + 1/σ₂²) (Smith & Schaefer 2015), and the weight
// of teeth along borders (FreeBoundaryOptions::straightness).
class SymmetricDirichlet {
 public:
  // Teeth of the border are those of `plane`. `chart` must outlive this.
  SymmetricDirichlet(const Chart& chart, const std::vector<Vec2>& plane, double straightness);

  struct Measured {
    double energy;  // above that of an isometry with straight borders; infinite if a triangle is flipped
    double l2;      // L² stretch at the scale where that is least
  };
  Measured measure(const std::vector<Vec2>& plane) const;
  double isometricEnergy() const { return isometric_; }

  // A step of Newton's method on the energy's positive part, whose eigenvectors are known in closed form
  // (Smith, de Goes & Kim 2019); returns its slope, which is negative but at a minimum. The linear system is
  // solved to a share of its right side by conjugate gradients: near an isometry it is that of linear
  // elasticity, which a weighted Laplacian of the chart preconditions well, and that has half the unknowns
  // and a quarter of the entries to factorise.
  double step(const std::vector<Vec2>& plane, Eigen::VectorXd& direction);

  // How far one can go before the first triangle collapses.
  double largestStep(const std::vector<Vec2>& plane, const Eigen::VectorXd& direction) const;

 private:
  // Three vertices in a row along a border, where that has teeth.
  struct Bend {
    std::array<std::uint32_t, 3> vertices;
    double weight;
  };

  void findBends(const Chart& chart, const std::vector<Vec2>& plane, double straightness);
  void addBend(const Bend& bend, const std::vector<Vec2>& plane, Eigen::VectorXd& gradient);
  void findPattern(std::size_t vertices);
  void addTriangle(std::size_t i, const std::vector<Vec2>& plane, Eigen::VectorXd& gradient);
  void renewPreconditioner();
  int solve(const Eigen::VectorXd& gradient, Eigen::VectorXd& direction);

  const std::vector<Triangle>& triangles_;
  std::vector<RestTriangle> rest_;
  double isometric_ = 0;
  std::vector<Bend> bends_;
  Eigen::SparseMatrix<double> hessian_;
  std::vector<std::array<int, 18>> slots_;
  std::vector<double> stiffness_;  // of triangles: the mean curvature of their energies, by area
  PairLaplacian preconditioner_;
  int last_iterations_ = 0;
};

}  // namespace bakelight::atlas
