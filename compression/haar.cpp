#include "compression/haar.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>

#include "transport/cube_map.h"

namespace bakelight::compression {
namespace {

void requireHaar(int cube_side) {
  if (!hasHaar(cube_side))
    throw std::invalid_argument("Haar wavelets need faces whose side is a power of two");
}

// Rows that are worked on together.
constexpr std::size_t kRowsAtOnce = 4096;

struct Coefficient {
  std::uint16_t index;
  float value;
};

// Of one sparse row: only squares that are not 0 are visited.
class SparseHaar {
 public:
  explicit SparseHaar(int cube_side) : side_(cube_side) {
    for (int side = cube_side; side >= 1; side /= 2)
      levels_.emplace_back(6 * static_cast<std::size_t>(side) * side, 0.0F);
  }

  void set(std::uint32_t column, float value) {
    levels_[0][column] = value;
    squares_.push_back(column);
  }

  void transform(std::vector<Coefficient>& out) {
    out.clear();
    std::size_t level = 0;
    for (int side = side_; side > 1; side /= 2, ++level) {
      const int half = side / 2;
      parents_.clear();
      for (const std::uint32_t square : squares_) parents_.push_back(parentOf(square, side));
      std::sort(parents_.begin(), parents_.end());
      parents_.erase(std::unique(parents_.begin(), parents_.end()), parents_.end());
      for (const std::uint32_t parent : parents_) split(level, parent, half, out);
      squares_.swap(parents_);
    }
    for (const std::uint32_t face : squares_) {
      add(out, face, 0, 0, levels_[level][face]);
      levels_[level][face] = 0;
    }
    squares_.clear();
    std::sort(out.begin(), out.end(),
              [](const Coefficient& a, const Coefficient& b) { return a.index < b.index; });
  }

 private:
  static std::uint32_t parentOf(std::uint32_t square, int side) {
    const std::uint32_t s = side, face = square / (s * s), x = square % s, y = square / s % s, half = s / 2;
    return (face * half + y / 2) * half + x / 2;
  }

  void add(std::vector<Coefficient>& out, std::uint32_t face, std::uint32_t x, std::uint32_t y,
           float value) const {
    if (value == 0) return;
    const std::uint32_t side = side_;
    out.push_back({static_cast<std::uint16_t>((face * side + y) * side + x), value});
  }

  void split(std::size_t level, std::uint32_t parent, std::uint32_t half, std::vector<Coefficient>& out) {
    const std::uint32_t face = parent / (half * half), x = parent % half, y = parent / half % half;
    const std::size_t first = (static_cast<std::size_t>(face) * 2 * half + 2 * y) * 2 * half + 2 * x;
    std::vector<float>& children = levels_[level];
    const float a = children[first], b = children[first + 1], c = children[first + 2 * half],
                d = children[first + 2 * half + 1];
    children[first] = children[first + 1] = children[first + 2 * half] = children[first + 2 * half + 1] = 0;
    levels_[level + 1][parent] = (a + b + c + d) / 2;
    add(out, face, x + half, y, (a - b + c - d) / 2);
    add(out, face, x, y + half, (a + b - c - d) / 2);
    add(out, face, x + half, y + half, (a - b - c + d) / 2);
  }

  int side_;
  std::vector<std::vector<float>> levels_;  // 0 but where squares are
  std::vector<std::uint32_t> squares_, parents_;
};

}  // namespace

bool hasHaar(int cube_side) {
  return cube_side >= 1 && std::has_single_bit(static_cast<unsigned>(cube_side));
}

void forwardHaar(int cube_side, std::span<Radiance4> faces) {
  requireHaar(cube_side);
  const std::size_t stride = cube_side;
  std::vector<Radiance4> next(stride * stride);
  for (std::size_t face = 0; face < 6; ++face) {
    Radiance4* values = faces.data() + face * stride * stride;
    for (std::size_t half = stride / 2; half >= 1; half /= 2) {
      for (std::size_t y = 0; y < half; ++y)
        for (std::size_t x = 0; x < half; ++x) {
          const Radiance4* at = values + 2 * y * stride + 2 * x;
          const Radiance4 a = at[0], b = at[1], c = at[stride], d = at[stride + 1];
          next[y * stride + x] = (a + b + c + d) / 2;
          next[y * stride + x + half] = (a - b + c - d) / 2;
          next[(y + half) * stride + x] = (a + b - c - d) / 2;
          next[(y + half) * stride + x + half] = (a - b - c + d) / 2;
        }
      for (std::size_t y = 0; y < 2 * half; ++y)
        std::copy_n(&next[y * stride], 2 * half, values + y * stride);
    }
  }
}

void inverseHaar(int cube_side, std::span<Radiance4> faces) {
  requireHaar(cube_side);
  const std::size_t stride = cube_side;
  std::vector<Radiance4> next(stride * stride);
  for (std::size_t face = 0; face < 6; ++face) {
    Radiance4* values = faces.data() + face * stride * stride;
    for (std::size_t half = 1; half < stride; half *= 2) {
      for (std::size_t y = 0; y < half; ++y)
        for (std::size_t x = 0; x < half; ++x) {
          const Radiance4 mean = values[y * stride + x], across = values[y * stride + x + half],
                          up = values[(y + half) * stride + x], both = values[(y + half) * stride + x + half];
          Radiance4* at = &next[2 * y * stride + 2 * x];
          at[0] = (mean + across + up + both) / 2;
          at[1] = (mean - across + up - both) / 2;
          at[stride] = (mean + across - up - both) / 2;
          at[stride + 1] = (mean - across - up + both) / 2;
        }
      for (std::size_t y = 0; y < 2 * half; ++y)
        std::copy_n(&next[y * stride], 2 * half, values + y * stride);
    }
  }
}

std::vector<float> haarAreas(int cube_side) {
  requireHaar(cube_side);
  const std::size_t side = cube_side;
  std::vector<double> solid_angles(side * side);
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x)
      solid_angles[y * side + x] =
          transport::cubeTexelSolidAngle(static_cast<int>(x), static_cast<int>(y), cube_side);
  std::vector<float> areas(side * side);
  // From squares of one texel up.
  for (std::size_t half = side / 2; half >= 1; half /= 2) {
    std::vector<double> parents(half * half);
    for (std::size_t y = 0; y < half; ++y)
      for (std::size_t x = 0; x < half; ++x) {
        const double* at = &solid_angles[2 * y * 2 * half + 2 * x];
        parents[y * half + x] = at[0] + at[1] + at[2 * half] + at[2 * half + 1];
        for (const std::size_t i : {y * side + x + half, (y + half) * side + x, (y + half) * side + x + half})
          areas[i] = static_cast<float>(parents[y * half + x]);
      }
    solid_angles.swap(parents);
  }
  areas[0] = static_cast<float>(solid_angles[0]);
  std::vector<float> all;
  for (int face = 0; face < 6; ++face) all.insert(all.end(), areas.begin(), areas.end());
  return all;
}

WaveletRows haarRows(const formats::PixelCodes& codes) {
  requireHaar(codes.cube_side);
  const std::size_t chunks = (codes.rowCount() + kRowsAtOnce - 1) / kRowsAtOnce;
  std::vector<WaveletRows> parts(chunks);
  const float scale = 1.0F / static_cast<float>(codes.subsamples * codes.subsamples);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    SparseHaar haar(codes.cube_side);
    std::vector<Coefficient> coefficients;
    WaveletRows& part = parts[chunk];
    for (std::size_t row = chunk * kRowsAtOnce; row < std::min(codes.rowCount(), (chunk + 1) * kRowsAtOnce);
         ++row) {
      for (std::uint64_t i = codes.row_offsets[row]; i < codes.row_offsets[row + 1]; ++i)
        haar.set(codes.columns[i], static_cast<float>(codes.codes[i]) * scale);
      haar.transform(coefficients);
      for (const Coefficient& coefficient : coefficients) {
        part.indices.push_back(coefficient.index);
        part.values.push_back(coefficient.value);
      }
      part.offsets.push_back(part.indices.size());
    }
  });
  WaveletRows rows;
  rows.cube_side = codes.cube_side;
  for (WaveletRows& part : parts) {
    const std::uint64_t before = rows.indices.size();
    for (std::size_t row = 1; row < part.offsets.size(); ++row)
      rows.offsets.push_back(before + part.offsets[row]);
    rows.indices.insert(rows.indices.end(), part.indices.begin(), part.indices.end());
    rows.values.insert(rows.values.end(), part.values.begin(), part.values.end());
    part = {};
  }
  return rows;
}

}  // namespace bakelight::compression
