// Light that bounces between diffuse surfaces: x = x0 + F (ρ x), for all coefficients at once (Sloan et al.
// 2002, section 5; in matrix form Lehtinen & Kautz 2003).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/buried_fill.h"
#include "transport/form_factors.h"

namespace bakelight::transport {

// A table of transfer, points × row_size; rows padded with zeros to whole tiles (quadrature.h).
struct TransferField {
  std::size_t columns = 0, row_size = 0;
  std::vector<float> values;

  TransferField(std::size_t point_count, std::size_t column_count);
  std::size_t pointCount() const { return values.size() / row_size; }
  std::span<float> row(std::size_t point) { return std::span(values).subspan(point * row_size, columns); }
  std::span<const float> row(std::size_t point) const {
    return std::span(values).subspan(point * row_size, columns);
  }
};

struct InterreflectionOptions {
  // Passes go on until the light estimated to be missing is below this share of all light.
  double threshold = 1e-3;
  int bounces = 0;       // > 0: exactly so many passes, whatever is missing then
  int max_passes = 100;  // a pass is one multiplication by F
  // What the fields beside `x` may take; at least those that a solution needs are taken whatever it says.
  std::size_t field_bytes = std::size_t{1} << 40;
};

struct InterreflectionReport {
  // After each pass: norm of what a further bounce would add (in plain passes: what this bounce added) ÷ norm
  // of x0.
  std::vector<double> added_energy;
  std::string solver = "passes";  // or "gmres", where bounces would have added up too slowly
  // Estimate of ‖error‖ ÷ ‖x‖ from above: the next bounce ÷ (1 − largest share of light that a point gets
  // back). A bound in the maximum norm; norms here are root mean squares over points and coefficients.
  double error_bound = 0;
  double largest_return = 0;  // max over points of Σ F ρ: below 1 unless a cavity is closed and white
  double direct_norm = 0;     // of x0
  bool converged = true;
};

// What solves one set of columns beside another: each pass added what both did.
InterreflectionReport together(const InterreflectionReport& a, const InterreflectionReport& b);

// Puts x0 into a field of the right shape.
using DirectLight = std::function<void(TransferField&)>;

// `x` becomes the solution for what `direct` gives. A row of `factors` is what a point sees of the points:
// the cosine-weighted share of its hemisphere that falls to each, transfer being interpolated within a hit
// triangle. `reflectance` has one albedo a point, `channel_of_column` says which of its colours counts in
// each column. Buried vertices are filled before each pass and in the result. Passes are plain bounces as
// long as they converge fast; where their ratio says that more than a few would still be needed (ρ(1−f) → 1),
// restarted GMRES takes over, every column on its own Krylov space but sharing the passes. Deterministic
// whatever the threads. Cost of a pass: non-zeros × columns multiply-adds. Memory: two further fields; with
// GMRES three and its space, which is 20 fields if there is room for them, and at least 2.
InterreflectionReport solveInterreflection(const FormFactors& factors,
                                           std::span<const formats::Float3> reflectance,
                                           std::span<const std::uint8_t> channel_of_column,
                                           const BuriedFill& fill, const InterreflectionOptions& options,
                                           const DirectLight& direct, TransferField& x);

}  // namespace bakelight::transport
