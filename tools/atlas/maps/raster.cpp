#include "tools/atlas/maps/raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tools/atlas/exact.h"

namespace bakelight::atlas {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool isFinite(const TexelTriangle& triangle) {
  return triangle[0].allFinite() && triangle[1].allFinite() && triangle[2].allFinite();
}

// The smallest and largest of the corners' coordinates along an axis.
std::pair<double, double> extent(const TexelTriangle& triangle, int axis) {
  return std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
}

// Whole numbers from doubles of any size: `low` ≤ result ≤ `high`.
int clamped(double value, int low, int high) {
  return static_cast<int>(std::clamp(value, static_cast<double>(low), static_cast<double>(high)));
}

// Where the segment from a to b, which do not lie at one height, meets the line at height y.
double crossing(const Vec2& a, const Vec2& b, double y) {
  const bool rises = a.y() < b.y();
  const Vec2 &low = rises ? a : b, &high = rises ? b : a;
  return low.x() + (y - low.y()) / (high.y() - low.y()) * (high.x() - low.x());
}

// The same, right to which side of each whole number it lies.
double exactSideCrossing(const Vec2& a, const Vec2& b, double y) {
  constexpr double kFarFromRounding = 1e-6;
  const double x = crossing(a, b, y), whole = std::round(x);
  if (std::abs(x - whole) > kFarFromRounding) return x;
  const bool rises = a.y() < b.y();
  // Left of the rising edge: the edge is to the right of the whole number.
  const int side = orientationOf(rises ? a : b, rises ? b : a, {whole, y});
  if (side == 0) return whole;
  return side > 0 ? std::max(x, std::nextafter(whole, kInfinity))
                  : std::min(x, std::nextafter(whole, -kInfinity));
}

// Whether a centre on the edge from a to b of a counter-clockwise triangle is the triangle's own.
bool isTopOrLeft(const Vec2& a, const Vec2& b) {
  return b.y() < a.y() || (b.y() == a.y() && b.x() < a.x());
}

bool claims(const TexelTriangle& triangle, const Vec2& center) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 &a = triangle[k], &b = triangle[(k + 1) % 3];
    const int side = orientationOf(a, b, center);
    if (side < 0 || (side == 0 && !isTopOrLeft(a, b))) return false;
  }
  return true;
}

}  // namespace

TexelTriangle texelTriangle(const formats::TriangleMesh& mesh, std::size_t triangle, int resolution) {
  TexelTriangle result;
  for (std::size_t k = 0; k < 3; ++k) {
    const formats::Float2& uv = mesh.texcoords[mesh.triangles[triangle][k]];
    result[k] = Vec2(uv[0], uv[1]) * resolution;
  }
  return result;
}

int orientationOf(const Vec2& a, const Vec2& b, const Vec2& c) {
  // Shewchuk 1997, "Adaptive precision floating-point arithmetic": the bound of orient2d's first stage.
  constexpr double kHalfUlp = 0x1p-53;
  constexpr double kErrorBound = (3 + 16 * kHalfUlp) * kHalfUlp;
  const double left = (a.x() - c.x()) * (b.y() - c.y()), right = (a.y() - c.y()) * (b.x() - c.x());
  const double determinant = left - right, bound = kErrorBound * (std::abs(left) + std::abs(right));
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return orientation(a, b, c);
}

void centerSpans(const TexelTriangle& triangle, int resolution, std::vector<RowSpan>& spans,
                 const RowRange& rows) {
  spans.clear();
  if (!isFinite(triangle)) return;
  TexelTriangle t = triangle;
  const int turn = orientationOf(t[0], t[1], t[2]);
  if (turn == 0) return;
  if (turn < 0) std::swap(t[1], t[2]);

  const auto [bottom, top] = extent(t, 1);
  const int first = clamped(std::ceil(bottom - 0.5), 0, resolution);
  const int last = clamped(std::floor(top - 0.5), -1, resolution - 1);
  for (int row = std::max(first, rows.begin); row <= last && row < rows.end; ++row) {
    const double y = row + 0.5;
    double low = kInfinity, high = -kInfinity;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 &a = t[k], &b = t[(k + 1) % 3];
      if (std::min(a.y(), b.y()) > y || std::max(a.y(), b.y()) < y) continue;
      const bool level = a.y() == b.y();
      const double x = level ? a.x() : crossing(a, b, y), other = level ? b.x() : x;
      low = std::min({low, x, other}), high = std::max({high, x, other});
    }
    // The centres inside follow each other without a gap: only those at both ends are in question.
    int begin = clamped(std::ceil(low - 0.5) - 1, 0, resolution);
    int end = clamped(std::floor(high - 0.5) + 2, 0, resolution);
    while (begin < end && !claims(t, {begin + 0.5, y})) ++begin;
    while (begin < end && !claims(t, {end - 0.5, y})) --end;
    if (begin < end) spans.push_back({row, begin, end});
  }
}

void touchedSpans(const TexelTriangle& triangle, int resolution, std::vector<RowSpan>& spans,
                  const RowRange& rows) {
  spans.clear();
  if (!isFinite(triangle)) return;
  const auto [bottom, top] = extent(triangle, 1);
  const int first = clamped(std::floor(bottom), 0, resolution);
  const int last = clamped(std::ceil(top) - 1, -1, resolution - 1);
  for (int row = std::max(first, rows.begin); row <= last && row < rows.end; ++row) {
    double low = kInfinity, high = -kInfinity;
    const auto take = [&](double x) { low = std::min(low, x), high = std::max(high, x); };
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 &a = triangle[k], &b = triangle[(k + 1) % 3];
      if (a.y() >= row && a.y() <= row + 1) take(a.x());
      for (const double y : {static_cast<double>(row), row + 1.0})
        if ((a.y() < y && b.y() > y) || (a.y() > y && b.y() < y)) take(exactSideCrossing(a, b, y));
    }
    const int begin = clamped(std::floor(low), 0, resolution);
    const int end = clamped(std::ceil(high), 0, resolution);
    if (begin < end) spans.push_back({row, begin, end});
  }
}

}  // namespace bakelight::atlas
