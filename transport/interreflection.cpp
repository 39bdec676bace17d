#include "transport/interreflection.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "transport/row_sums.h"

namespace bakelight::transport {

using formats::Float3;

namespace {

constexpr std::size_t kRowsPerChunk = 512;  // of sums over points: fixed, so that their order is
constexpr double kFewPasses = 6;
constexpr std::size_t kKrylovBytes = std::size_t{1} << 30;
constexpr std::size_t kLongestKrylov = 20;
constexpr std::size_t kGmresFields = 3;  // beside those that count for the length of its space

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

// One bounce.
class Bounce {
 public:
  Bounce(const FormFactors& factors, std::span<const Float3> reflectance,
         std::span<const std::uint8_t> channel_of_column, const BuriedFill& fill)
      : factors_(factors), reflectance_(reflectance), channel_of_column_(channel_of_column), fill_(fill) {}

  // Both have the same shape and are different tables. `x` is exit radiance afterwards.
  void consume(TransferField& x, TransferField& gathered) const {
    if (fill_.filledVertices() > 0) fill_.apply(x.values, x.row_size);
    forChunks(x.pointCount(), [&](std::size_t, std::size_t first, std::size_t end) {
      for (std::size_t p = first; p < end; ++p) {
        const auto row = x.row(p);
        for (std::size_t c = 0; c < row.size(); ++c) row[c] *= reflectance_[p][channel_of_column_[c]];
      }
    });
    gather(x, gathered);
  }
  // The same, with `exit` for what becomes of `x`.
  void apply(const TransferField& x, TransferField& exit, TransferField& gathered) const {
    exit.values = x.values;
    consume(exit, gathered);
  }

  double largestReturn() const {
    std::vector<double> largest(factors_.blockCount(), 0.0);
    tbb::parallel_for(std::size_t{0}, largest.size(), [&](std::size_t b) {
      const FormFactors::Block& block = factors_.block(b);
      std::vector<float> decoded;
      for (std::size_t row = 0; row < block.rowCount(); ++row) {
        const auto columns = block.columnsOf(row);
        const auto weights = block.weightsOf(row, decoded);
        double sum = 0;
        for (std::size_t k = 0; k < columns.size(); ++k) {
          const Float3& albedo = reflectance_[columns[k]];
          sum += static_cast<double>(weights[k]) * *std::max_element(albedo.begin(), albedo.end());
        }
        largest[b] = std::max(largest[b], sum);
      }
    });
    return largest.empty() ? 0 : *std::max_element(largest.begin(), largest.end());
  }

 private:
  void gather(const TransferField& exit, TransferField& gathered) const {
    tbb::parallel_for(std::size_t{0}, factors_.blockCount(), [&](std::size_t b) {
      const FormFactors::Block& block = factors_.block(b);
      std::vector<double> sums(exit.row_size);
      std::vector<float> decoded;
      for (std::size_t row = 0; row < block.rowCount(); ++row) {
        std::fill(sums.begin(), sums.end(), 0.0);
        accumulateRows(exit.values.data(), exit.row_size, block.columnsOf(row), block.weightsOf(row, decoded),
                       sums);
        const auto to = gathered.row(factors_.firstRow(b) + row);
        for (std::size_t c = 0; c < to.size(); ++c) to[c] = static_cast<float>(sums[c]);
      }
    });
  }

  const FormFactors& factors_;
  std::span<const Float3> reflectance_;
  std::span<const std::uint8_t> channel_of_column_;
  const BuriedFill& fill_;
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
  Gmres(const Bounce& bounce, TransferField residual)
      : bounce_(bounce),
        columns_(residual.columns),
        exit_(residual.pointCount(), residual.columns),
        bounced_(residual.pointCount(), residual.columns) {
    beta_ = roots(dots(residual, residual));
    scale(residual, inverted(beta_));
    for (const double beta : beta_) right_.push_back({beta});
    cosines_.resize(columns_), sines_.resize(columns_), triangle_.resize(columns_);
    basis_.push_back(std::move(residual));
  }

  // One more pass; the norm of the residual that is left then.
  double step() {
    TransferField next = basis_.back();
    bounce_.apply(basis_.back(), exit_, bounced_);
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

  const Bounce& bounce_;
  std::size_t columns_;
  TransferField exit_, bounced_;
  std::vector<TransferField> basis_;
  std::vector<double> beta_;
  std::vector<std::vector<double>> right_, cosines_, sines_;  // by column
  std::vector<std::vector<std::vector<double>>> triangle_;    // by column, then column of the triangle
};

// x0 + F ρ x − x.
TransferField residualOf(const Bounce& bounce, const DirectLight& direct, const TransferField& x) {
  TransferField residual(x.pointCount(), x.columns), exit(x.pointCount(), x.columns);
  bounce.apply(x, exit, residual);
  direct(exit);
  add(residual, exit);
  addScaled(residual, std::vector<double>(x.columns, -1.0), x);
  return residual;
}

}  // namespace

InterreflectionReport together(const InterreflectionReport& a, const InterreflectionReport& b) {
  InterreflectionReport both;
  both.direct_norm = std::hypot(a.direct_norm, b.direct_norm);
  for (std::size_t i = 0; i < std::max(a.added_energy.size(), b.added_energy.size()); ++i) {
    const auto added = [&](const InterreflectionReport& one) {
      return i < one.added_energy.size() ? one.added_energy[i] * one.direct_norm : 0;
    };
    both.added_energy.push_back(std::hypot(added(a), added(b)) / both.direct_norm);
  }
  both.solver = a.solver == b.solver ? a.solver : "gmres";
  both.error_bound = std::max(a.error_bound, b.error_bound);
  both.largest_return = std::max(a.largest_return, b.largest_return);
  both.converged = a.converged && b.converged;
  return both;
}

TransferField::TransferField(std::size_t point_count, std::size_t column_count)
    : columns(column_count), row_size(paddedToTiles(column_count)), values(point_count * row_size, 0.0f) {}

InterreflectionReport solveInterreflection(const FormFactors& factors, std::span<const Float3> reflectance,
                                           std::span<const std::uint8_t> channel_of_column,
                                           const BuriedFill& fill, const InterreflectionOptions& options,
                                           const DirectLight& direct, TransferField& x) {
  const Bounce bounce(factors, reflectance, channel_of_column, fill);
  InterreflectionReport report;
  report.largest_return = bounce.largestReturn();
  // A closed white cavity gives every share back; there the bound says nothing and the passes decide.
  const double kept = std::max(1 - report.largest_return, 1e-4);
  direct(x);
  const double initial = report.direct_norm = norm(x);
  const auto bound = [&](double added) { return initial > 0 ? added / kept / norm(x) : 0; };
  const auto done = [&] {
    if (options.bounces > 0) return static_cast<int>(report.added_energy.size()) >= options.bounces;
    return report.error_bound <= options.threshold ||
           static_cast<int>(report.added_energy.size()) >= options.max_passes;
  };
  if (initial == 0) return report;

  bool slow = false;
  {  // Plain bounces.
    TransferField last = x, next(x.pointCount(), x.columns);
    do {
      bounce.consume(last, next);
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
  const std::size_t room = options.field_bytes / field_bytes;
  const std::size_t longest = std::min(std::clamp<std::size_t>(kKrylovBytes / field_bytes, 4, kLongestKrylov),
                                       std::max<std::size_t>(room, kGmresFields + 2) - kGmresFields);
  while (!done()) {
    report.solver = "gmres";
    Gmres gmres(bounce, residualOf(bounce, direct, x));
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

}  // namespace bakelight::transport
