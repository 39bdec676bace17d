// Throughput factors between the knots of a mesh: how much light that enters around one leaves around another.
#pragma once

#include <functional>
#include <vector>

#include "tools/kernels/knots.h"
#include "tools/kernels/reflectance.h"

namespace bakelight::kernels {

// Rows of entries; one value or three of each.
struct Matrix {
  std::vector<std::uint32_t> ends, columns;
  std::vector<float> values;
  std::size_t value_columns = 1;

  std::size_t rows() const { return ends.size(); }
};

// R_d between knots, smoothed where they are so near each other that hats over them could not follow it (Reflectance::smoothed). What smoothing
// takes away, kernels of texels and their blend weights give. Parts of the surface that are near in space but not along it, such as the sides of an
// ear, keep R_d, as a mean over the hats.
class Throughput {
 public:
  struct Options {
    double threshold = 1e-6;   // factors below it, relative to what enters around a knot, are dropped
    bool hierarchical = true;  // far knots for a smoother part, where there are enough knots
  };
  static constexpr std::uint64_t kMostFactors = 200'000'000;  // 3 GB of them
  struct Figures {
    double dropped_share = 0;     // of the total response, at most (a row's)
    std::size_t apart_pairs = 0;  // near in space, not along the surface
    // Knots that another one, not along the surface, is so near that means over hats say little of what passes between.
    std::size_t touching_knots = 0;
  };

  // `reflectance` reaches over the whole mesh; both outlive this. Throws std::length_error for so many factors that they would not fit (kMostFactors).
  // Cost: about 300 factors a knot and 1/250 of a knot's each other one; without far knots, those pairs whose factors reach `threshold`.
  Throughput(const Knots& knots, const Reflectance& reflectance, const Options& options);

  // Radius within which R_d is smoothed around a knot; that between two is the mean of theirs.
  float smoothing(std::size_t knot) const { return smoothing_[knot]; }
  // Between two knots that hang together along the surface, in 1/area.
  Rgb between(std::size_t a, std::size_t b) const {
    const Vec3 &from = knots_.positions[a], &to = knots_.positions[b];
    return reflectance_.smoothed(static_cast<float>((from - to).norm()), (smoothing_[a] + smoothing_[b]) / 2,
                                 reflectance_.along(knots_.point(a), knots_.point(b)));
  }
  // Σ over knots of sharpened factors, hats and all: what g is for these e (formats/translucency.h), areas in the asset's unit.
  std::vector<Rgb> respond(const std::vector<Rgb>& power) const;

  // Radius of what is smoother still, farther than that of any knot; and what all knots would send for these e if R_d were smooth over
  // `radius`, at most that one, everywhere; without sharpening.
  float outerSmoothing() const { return outer_smoothing_; }
  std::vector<Rgb> respondSmoothly(const std::vector<Rgb>& power, float radius) const;

  const Matrix& near() const { return near_; }
  const Matrix& spread() const { return spread_; }
  const Matrix& far() const { return far_; }
  std::size_t farCount() const { return far_.rows(); }
  const Figures& figures() const { return figures_; }

 private:
  void chooseFarKnots();
  std::vector<Rgb> respondByFarKnots(const std::vector<Rgb>& power) const;
  bool isFollowed(double radius, double cell) const;
  std::vector<Rgb> byWayOfFar(std::size_t knot) const;
  Rgb givenByFar(const std::vector<Rgb>& by_way_of_far, std::size_t knot, float distance) const;
  double hatArea() const;
  double reachOfFactors(double hat_area) const;
  void makeNear();
  void makeSpread();
  void makeFar();
  Rgb apart(std::size_t a, std::size_t b) const;

  const Knots& knots_;
  const Reflectance& reflectance_;
  Options options_;
  std::vector<float> smoothing_;
  float outer_smoothing_ = 0;
  bool has_far_ = false;
  std::vector<Point> far_points_;  // of `knots`
  Matrix near_, spread_, far_;
  Figures figures_;
};

// Those of `knots` that edges lead to from `from` without leaving a ball around it, ascending.
void alongSurface(const Knots& knots, std::size_t from, double radius, std::vector<std::uint32_t>& found);

// y = A x, and x = Aᵀ y.
std::vector<Rgb> multiply(const Matrix& matrix, const std::vector<Rgb>& x);
std::vector<Rgb> multiplyTransposed(const Matrix& matrix, const std::vector<Rgb>& y, std::size_t columns);
Matrix sharpeningOf(const Knots& knots);

}  // namespace bakelight::kernels
