#include "compression/tolerance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "transport/cube_map.h"

namespace bakelight::compression {
namespace {

struct Entry {
  std::uint16_t column;
  std::uint8_t code;
};

// Of a texel, or of the four of a square: codes become 0 or full.
struct Change {
  double size = 0;      // Σ |change| · solid angle
  std::uint32_t place;  // a column, or the lowest of a square's
  bool fill = false;
};

class RowChanger {
 public:
  RowChanger(const formats::PixelCodes& codes, double allowed)
      : codes_(codes),
        allowed_(allowed),
        full_(static_cast<std::uint8_t>(codes.subsamples * codes.subsamples)) {
    for (int face = 0; face < transport::kCubeFaces; ++face)
      for (int y = 0; y < codes.cube_side; ++y)
        for (int x = 0; x < codes.cube_side; ++x)
          angles_.push_back(transport::cubeTexelSolidAngle(x, y, codes.cube_side));
  }

  struct Result {
    std::vector<Entry> entries;
    double error = 0, white_sky = 0;
  };
  Result change(std::size_t row) const {
    Result result;
    for (std::uint64_t i = codes_.row_offsets[row]; i < codes_.row_offsets[row + 1]; ++i)
      result.entries.push_back({codes_.columns[i], codes_.codes[i]});
    apply(result, fractionChanges(result.entries), 1);
    apply(result, squareChanges(result.entries), 2);
    return result;
  }

 private:
  double angleOf(std::uint32_t column, int code) const { return angles_[column] * code / full_; }

  std::vector<Change> fractionChanges(const std::vector<Entry>& entries) const {
    std::vector<Change> changes;
    for (const Entry& entry : entries) {
      if (entry.code == full_) continue;
      const bool fill = 2 * entry.code >= full_;
      changes.push_back({angleOf(entry.column, fill ? full_ - entry.code : entry.code), entry.column, fill});
    }
    return changes;
  }

  // Squares that lie on even rows and columns; of a map with an odd side the last ones are left as they are.
  std::vector<Change> squareChanges(const std::vector<Entry>& entries) const {
    const std::uint32_t side = static_cast<std::uint32_t>(codes_.cube_side);
    std::vector<std::uint32_t> squares;
    for (const Entry& entry : entries) {
      const std::uint32_t x = entry.column % side, y = entry.column / side % side;
      if ((x | 1) < side && (y | 1) < side) squares.push_back(entry.column - x % 2 - y % 2 * side);
    }
    std::sort(squares.begin(), squares.end());
    squares.erase(std::unique(squares.begin(), squares.end()), squares.end());
    std::vector<Change> changes;
    for (const std::uint32_t square : squares) {
      double to_fill = 0, to_drop = 0;
      for (const std::uint32_t column : {square, square + 1, square + side, square + side + 1}) {
        const int code = codeAt(entries, column);
        to_fill += angleOf(column, full_ - code), to_drop += angleOf(column, code);
      }
      if (to_fill > 0) changes.push_back({std::min(to_fill, to_drop), square, to_fill <= to_drop});
    }
    return changes;
  }

  static int codeAt(const std::vector<Entry>& entries, std::uint32_t column) {
    const auto at = std::lower_bound(entries.begin(), entries.end(), column,
                                     [](const Entry& entry, std::uint32_t c) { return entry.column < c; });
    return at != entries.end() && at->column == column ? at->code : 0;
  }

  // `width` 1: texels, 2: squares.
  void apply(Result& result, std::vector<Change> changes, std::uint32_t width) const {
    std::sort(changes.begin(), changes.end(), [](const Change& a, const Change& b) {
      return a.size != b.size ? a.size < b.size : a.place < b.place;
    });
    std::vector<Entry> changed;
    for (const Change& change : changes) {
      // Strict against rounding: the sum of the sizes stays below.
      if (result.error + change.size > allowed_) break;
      result.error += change.size;
      for (std::uint32_t i = 0; i < width * width; ++i) {
        const std::uint32_t column =
            change.place + i % width + i / width * static_cast<std::uint32_t>(codes_.cube_side);
        const int before = codeAt(result.entries, column), after = change.fill ? full_ : 0;
        result.white_sky += angleOf(column, after) - angleOf(column, before);
        changed.push_back({static_cast<std::uint16_t>(column), static_cast<std::uint8_t>(after)});
      }
    }
    for (const Entry& entry : result.entries)
      if (std::none_of(changed.begin(), changed.end(),
                       [&](const Entry& c) { return c.column == entry.column; }))
        changed.push_back(entry);
    std::erase_if(changed, [](const Entry& entry) { return entry.code == 0; });
    std::sort(changed.begin(), changed.end(),
              [](const Entry& a, const Entry& b) { return a.column < b.column; });
    result.entries = std::move(changed);
  }

  const formats::PixelCodes& codes_;
  double allowed_;
  std::uint8_t full_;
  std::vector<double> angles_;
};

}  // namespace

TolerantRows withinTolerance(const formats::PixelCodes& codes, double tolerance) {
  if (!(tolerance >= 0 && tolerance <= 1)) throw std::invalid_argument("a tolerance is 0 to 1");
  const double cell = 2 * std::numbers::pi / (codes.local_side * codes.local_side);
  const RowChanger changer(codes, tolerance * cell);
  std::vector<RowChanger::Result> results(codes.rowCount());
  tbb::parallel_for(std::size_t{0}, codes.rowCount(),
                    [&](std::size_t row) { results[row] = changer.change(row); });
  TolerantRows changed;
  changed.rows.cube_side = codes.cube_side, changed.rows.local_side = codes.local_side;
  changed.rows.subsamples = codes.subsamples;
  double squares = 0, white_squares = 0;
  for (const RowChanger::Result& result : results) {
    for (const Entry& entry : result.entries)
      changed.rows.columns.push_back(entry.column), changed.rows.codes.push_back(entry.code);
    changed.rows.row_offsets.push_back(changed.rows.columns.size());
    const double error = result.error / cell, white = std::abs(result.white_sky) / cell;
    changed.figures.largest_error = std::max(changed.figures.largest_error, error);
    changed.figures.white_sky_error = std::max(changed.figures.white_sky_error, white);
    squares += error * error, white_squares += white * white;
    if (error > 0) ++changed.figures.changed_rows;
  }
  const auto rows = static_cast<double>(std::max<std::size_t>(1, results.size()));
  changed.figures.rms_error = std::sqrt(squares / rows);
  changed.figures.white_sky_rms = std::sqrt(white_squares / rows);
  return changed;
}

}  // namespace bakelight::compression
