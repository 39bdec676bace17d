#include "tools/transfer/interreflection.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tools/transfer/quadrature.h"

namespace bakelight::transfer {

using formats::Float3;

namespace {

constexpr std::size_t kRowsPerChunk = 512;  // of sums over points: fixed, so that their order is
constexpr double kFewPasses = 6;
constexpr std::size_t kKrylovBytes = std::size_t{1} << 30;
constexpr std::size_t kLongestKrylov = 20;

// Calls body(first, end) for chunks of the points.
template <class Body>
void forChunks(std::size_t points, const Body& body) {
  const std::size_t chunks = (points + kRowsPerChunk - 1) / kRowsPerChunk;
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    body(chunk, chunk * kRowsPerChunk, std::min((chunk + 1) * kRowsPerChunk, points));
  });
}

// Per column: Σ over points of a · b.
std::vector<double> dots(const TransferField& a, const TransferField& b) {
  const std::size_t points = a.pointCount(), columns = a.columns;
  std::vector<std::vector<double>> parts((points + kRowsPerChunk - 1) / kRowsPerChunk);
  forChunks(points, [&](std::size_t chunk, std::size_t first, std::size_t end) {
    std::vector<double>& part = parts[chunk];
    part.assign(columns, 0.0);
    for (std::size_t p = first; p < end; ++p) {
      const auto row_a = a.row(p), row_b = b.row(p);
      for (std::size_t c = 0; c < columns; ++c) part[c] += static_cast<double>(row_a[c]) * row_b[c];
    }
  });
  std::vector<double> sums(columns, 0.0);
  for (const auto& part : parts)
    for (std::size_t c = 0; c < columns; ++c) sums[c] += part[c];
  return sums;
}

double total(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}
double norm(const TransferField& field) {
  return std::sqrt(total(dots(field, field)));
}

// a += factor[column] · b.
void addScaled(TransferField& a, std::span<const double> factor, const TransferField& b) {
  forChunks(a.pointCount(), [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t p = first; p < end; ++p) {
      const auto row_a = a.row(p);
      const auto row_b = b.row(p);
      for (std::size_t c = 0; c < row_a.size(); ++c)
        row_a[c] = static_cast<float>(row_a[c] + factor[c] * row_b[c]);
    }
  });
}
void add(TransferField& a, const TransferField& b) {
  addScaled(a, std::vector<double>(a.columns, 1.0), b);
}
void scale(TransferField& a, std::span<const double> factor) {
  forChunks(a.pointCount(), [&](std::size_t, std::size_t first, std::size_t end) {
    for (std::size_t p = first; p < end; ++p) {
      const auto row = a.row(p);
      for (std::size_t c = 0; c < row.size(); ++c) row[c] = static_cast<float>(row[c] * factor[c]);
    }
  });
}

// One bounce. Keeps the exit radiance between bounces, as a fresh table costs more to map than to fill.
class Bounce {
 public:
  Bounce(const FormFactors& factors, std::span<const Float3> reflectance,
         std::span<const std::uint8_t> channel_of_column, const BuriedFill& fill)
      : factors_(factors),
        reflectance_(reflectance),
        channel_of_column_(channel_of_column),
        fill_(fill),
        exit_(factors.pointCount(), channel_of_column.size()) {}

  // `gathered` has the shape of `x` and is another table.
  void apply(const TransferField& x, TransferField& gathered) {
    if (fill_.filledVertices() == 0) {
      reflect(x);
    } else {
      exit_.values = x.values;
      fill_.apply(exit_.values, exit_.row_size);
      reflect(exit_);
    }
    forChunks(x.pointCount(), [&](std::size_t, std::size_t first, std::size_t end) {
      std::vector<double> sums(x.row_size);
      for (std::size_t p = first; p < end; ++p) {
        const std::uint64_t begin = factors_.row_begin[p], count = factors_.row_begin[p + 1] - begin;
        std::fill(sums.begin(), sums.end(), 0.0);
        accumulateRows(exit_.values.data(), exit_.row_size, std::span(factors_.columns).subspan(begin, count),
                       std::span(factors_.weights).subspan(begin, count), sums);
        const auto row = gathered.row(p);
        for (std::size_t c = 0; c < row.size(); ++c) row[c] = static_cast<float>(sums[c]);
      }
    });
  }

  double largestReturn() const {
    double largest = 0;
    for (std::size_t p = 0; p < factors_.pointCount(); ++p) {
      double sum = 0;
      for (std::uint64_t k = factors_.row_begin[p]; k < factors_.row_begin[p + 1]; ++k) {
        const Float3& albedo = reflectance_[factors_.columns[k]];
        sum += static_cast<double>(factors_.weights[k]) * *std::max_element(albedo.begin(), albedo.end());
      }
      largest = std::max(largest, sum);
    }
    return largest;
  }

 private:
  // exit_ = ρ x; x may be exit_ itself.
  void reflect(const TransferField& x) {
    forChunks(x.pointCount(), [&](std::size_t, std::size_t first, std::size_t end) {
      for (std::size_t p = first; p < end; ++p) {
        const auto from = x.row(p);
        const auto to = exit_.row(p);
        for (std::size_t c = 0; c < to.size(); ++c) to[c] = from[c] * reflectance_[p][channel_of_column_[c]];
      }
    });
  }

  const FormFactors& factors_;
  std::span<const Float3> reflectance_;
  std::span<const std::uint8_t> channel_of_column_;
  const BuriedFill& fill_;
  TransferField exit_;
};

std::vector<double> inverted(std::vector<double> values) {
  for (double& value : values) value = value > 0 ? 1 / value : 0;
  return values;
}
std::vector<double> roots(std::vector<double> values) {
  for (double& value : values) value = std::sqrt(value);
  return values;
}

// GMRES for (1 − F ρ) x = x0, one small least-squares problem a column (Saad & Schultz 1986), by Givens
// rotations.
class Gmres {
 public:
  // Starts from `residual`, what the present x lacks: (1 − F ρ) correction = residual.
  Gmres(Bounce& bounce, TransferField residual)
      : bounce_(bounce), columns_(residual.columns), bounced_(residual.pointCount(), residual.columns) {
    beta_ = roots(dots(residual, residual));
    scale(residual, inverted(beta_));
    for (const double beta : beta_) right_.push_back({beta});
    cosines_.resize(columns_), sines_.resize(columns_), triangle_.resize(columns_);
    basis_.push_back(std::move(residual));
  }

  // One more pass; the norm of the residual that is left then.
  double step() {
    TransferField next = basis_.back();
    bounce_.apply(basis_.back(), bounced_);
    addScaled(next, std::vector<double>(columns_, -1.0), bounced_);
    std::vector<std::vector<double>> heights;
    for (const TransferField& vector : basis_) {
      std::vector<double> projection = dots(next, vector);
      std::vector<double> negative = projection;
      for (double& value : negative) value = -value;
      addScaled(next, negative, vector);
      heights.push_back(std::move(projection));
    }
    heights.push_back(roots(dots(next, next)));
    // What is left of a column whose space is exhausted is rounding.
    for (std::size_t c = 0; c < columns_; ++c) {
      double size = 0;
      for (const auto& height : heights) size = std::max(size, std::abs(height[c]));
      if (heights.back()[c] < 1e-6 * size) heights.back()[c] = 0;
    }
    scale(next, inverted(heights.back()));
    basis_.push_back(std::move(next));
    double squares = 0;
    for (std::size_t c = 0; c < columns_; ++c) squares += rotate(c, heights);
    return std::sqrt(squares);
  }

  void addCorrection(TransferField& x) const {
    const std::size_t size = basis_.size() - 1;
    std::vector<std::vector<double>> factors(size, std::vector<double>(columns_, 0.0));
    for (std::size_t c = 0; c < columns_; ++c)
      for (std::size_t i = size; i-- > 0;) {
        double sum = right_[c][i];
        for (std::size_t k = i + 1; k < size; ++k) sum -= triangle_[c][k][i] * factors[k][c];
        const double diagonal = triangle_[c][i][i];
        factors[i][c] = diagonal != 0 ? sum / diagonal : 0;
      }
    for (std::size_t i = 0; i < size; ++i) addScaled(x, factors[i], basis_[i]);
  }

 private:
  // Brings the new column of the Hessenberg matrix to triangular form; the squared residual left.
  double rotate(std::size_t c, const std::vector<std::vector<double>>& heights) {
    std::vector<double> column;
    for (const auto& height : heights) column.push_back(height[c]);
    const std::size_t last = column.size() - 2;
    for (std::size_t i = 0; i < last; ++i) {
      const double upper = column[i], lower = column[i + 1];
      column[i] = cosines_[c][i] * upper + sines_[c][i] * lower;
      column[i + 1] = -sines_[c][i] * upper + cosines_[c][i] * lower;
    }
    const double length = std::hypot(column[last], column[last + 1]);
    cosines_[c].push_back(length > 0 ? column[last] / length : 1);
    sines_[c].push_back(length > 0 ? column[last + 1] / length : 0);
    column[last] = length;
    column.pop_back();
    triangle_[c].push_back(std::move(column));
    const double right = right_[c][last];
    right_[c][last] = cosines_[c][last] * right;
    right_[c].push_back(-sines_[c][last] * right);
    return right_[c].back() * right_[c].back();
  }

  Bounce& bounce_;
  std::size_t columns_;
  TransferField bounced_;
  std::vector<TransferField> basis_;
  std::vector<double> beta_;
  std::vector<std::vector<double>> right_, cosines_, sines_;  // by column
  std::vector<std::vector<std::vector<double>>> triangle_;    // by column, then column of the triangle
};

// x0 + F ρ x − x.
TransferField residualOf(Bounce& bounce, const TransferField& x0, const TransferField& x) {
  TransferField residual(x.pointCount(), x.columns);
  bounce.apply(x, residual);
  add(residual, x0);
  addScaled(residual, std::vector<double>(x.columns, -1.0), x);
  return residual;
}

}  // namespace

TransferField::TransferField(std::size_t point_count, std::size_t column_count)
    : columns(column_count), row_size(paddedToTiles(column_count)), values(point_count * row_size, 0.0f) {}

InterreflectionReport solveInterreflection(const FormFactors& factors, std::span<const Float3> reflectance,
                                           std::span<const std::uint8_t> channel_of_column,
                                           const BuriedFill& fill, const InterreflectionOptions& options,
                                           TransferField& x) {
  Bounce bounce(factors, reflectance, channel_of_column, fill);
  InterreflectionReport report;
  report.largest_return = bounce.largestReturn();
  // A closed white cavity gives every share back; there the bound says nothing and the passes decide.
  const double kept = std::max(1 - report.largest_return, 1e-4);
  const double initial = norm(x);
  const auto bound = [&](double added) { return initial > 0 ? added / kept / norm(x) : 0; };
  const auto done = [&] {
    if (options.bounces > 0) return static_cast<int>(report.added_energy.size()) >= options.bounces;
    return report.error_bound <= options.threshold ||
           static_cast<int>(report.added_energy.size()) >= options.max_passes;
  };
  if (initial == 0) return report;

  const TransferField x0 = x;
  bool slow = false;
  {  // Plain bounces.
    TransferField last = x, next(x.pointCount(), x.columns);
    do {
      bounce.apply(last, next);
      std::swap(last, next);
      add(x, last);
      const double added = norm(last);
      report.added_energy.push_back(added / initial);
      report.error_bound = bound(added * std::min(report.largest_return, 1.0));
      const std::size_t passes = report.added_energy.size();
      if (options.bounces == 0 && passes >= 2) {
        const double ratio = report.added_energy[passes - 1] / report.added_energy[passes - 2];
        const double further =
            ratio < 1 ? std::log(options.threshold / report.error_bound) / std::log(ratio) : 1e9;
        slow = further > kFewPasses;
      }
    } while (!done() && !slow);
  }

  const std::size_t field_bytes = x.values.size() * sizeof(float);
  const std::size_t longest = std::clamp<std::size_t>(kKrylovBytes / field_bytes, 4, kLongestKrylov);
  while (!done()) {
    report.solver = "gmres";
    Gmres gmres(bounce, residualOf(bounce, x0, x));
    for (std::size_t k = 0; k < longest && !done(); ++k) {
      const double left = gmres.step();
      report.added_energy.push_back(left / initial);
      report.error_bound = bound(left);
    }
    gmres.addCorrection(x);
  }
  report.converged = report.error_bound <= options.threshold;
  fill.apply(x.values, x.row_size);
  return report;
}

}  // namespace bakelight::transfer
