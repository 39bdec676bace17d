#include "tools/atlas/flatten/convex_border.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace bakelight::atlas {
namespace {

constexpr double kLargestShare = 0.98;  // of a side, of the others together
constexpr double kLeastSlack =
    0.02;  // of the shortest side, by which the others exceed one that cannot be divided
constexpr double kShortestEdge = 1e-6;  // of a side ÷ its edges
constexpr double kLargestBulge_rad = std::numbers::pi / 6;
constexpr std::uint32_t kNone = ~0u;

std::vector<std::uint32_t> uniformCorners(const BorderPath& path, int count) {
  const auto wanted = static_cast<std::uint32_t>(std::clamp<std::int64_t>(count, 3, path.size()));
  std::vector<std::uint32_t> corners;
  for (std::uint32_t k = 0; k < wanted; ++k) {
    const double target = path.length_to.back() * k / wanted;
    const auto above = std::lower_bound(path.length_to.begin(), path.length_to.end(), target);
    auto i = static_cast<std::uint32_t>(above - path.length_to.begin());
    if (i > 0 && target - path.length_to[i - 1] <= path.length_to[i] - target) --i;
    // Room for those before and those to come.
    const std::uint32_t least = corners.empty() ? 0 : corners.back() + 1;
    corners.push_back(std::clamp(i, least, path.size() - (wanted - k)));
  }
  return corners;
}

std::vector<std::uint32_t> chosenCorners(const BorderPath& path, std::span<const std::uint32_t> chosen,
                                         std::size_t vertex_count) {
  std::vector<std::uint8_t> is_chosen(vertex_count, 0);
  for (const std::uint32_t v : chosen) is_chosen[v] = 1;
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < path.size(); ++i)
    if (is_chosen[path.vertices[i]]) corners.push_back(i);
  return corners;
}

std::vector<Side> sidesOf(const BorderPath& path, const std::vector<std::uint32_t>& corners) {
  std::vector<Side> sides;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const std::uint32_t begin = corners[k];
    const std::uint32_t end = k + 1 < corners.size() ? corners[k + 1] : corners[0] + path.size();
    sides.push_back({begin, end, path.at(end) - path.at(begin)});
  }
  return sides;
}

// The inner vertex of a side nearest to its middle, or kNone.
std::uint32_t middleOf(const BorderPath& path, const Side& side) {
  const double middle = (path.at(side.begin) + path.at(side.end)) / 2;
  std::uint32_t best = kNone;
  for (std::uint32_t i = side.begin + 1; i < side.end; ++i)
    if (best == kNone || std::abs(path.at(i) - middle) < std::abs(path.at(best) - middle)) best = i;
  return best;
}

// The longest side that has a vertex inside, or the number of sides.
std::size_t longestDivisible(const std::vector<Side>& sides) {
  std::size_t best = sides.size();
  for (std::size_t k = 0; k < sides.size(); ++k)
    if (sides[k].end - sides[k].begin > 1 && (best == sides.size() || sides[k].length > sides[best].length))
      best = k;
  return best;
}

double lengthOfOthers(const std::vector<Side>& sides, std::size_t k) {
  double sum = 0;
  for (std::size_t j = 0; j < sides.size(); ++j)
    if (j != k) sum += sides[j].length;
  return sum;
}

// Less than for a side that can be divided, as thin triangles are to keep their shape.
void shorten(std::vector<Side>& sides, std::size_t k, double others, ConvexBorder& border) {
  const Side& shortest = *std::min_element(sides.begin(), sides.end(),
                                           [](const Side& a, const Side& b) { return a.length < b.length; });
  const double most = others - kLeastSlack * shortest.length;
  if (sides[k].length <= most) return;
  sides[k].length = most;
  ++border.shortened_sides;
}

std::vector<Side> closableSides(const BorderPath& path, ConvexBorder& border) {
  while (true) {
    std::vector<Side> sides = sidesOf(path, border.corners);
    std::size_t k = longestDivisible(sides);
    const bool too_few = sides.size() < 3;
    if (!too_few) {
      k = static_cast<std::size_t>(
          std::max_element(sides.begin(), sides.end(),
                           [](const Side& a, const Side& b) { return a.length < b.length; }) -
          sides.begin());
      const double others = lengthOfOthers(sides, k);
      if (sides[k].end - sides[k].begin == 1) {
        shorten(sides, k, others, border);
        return sides;
      }
      if (sides[k].length <= kLargestShare * others) return sides;
    }
    const std::uint32_t corner = sides.empty() ? 0 : middleOf(path, sides[k]) % path.size();
    border.corners.insert(std::upper_bound(border.corners.begin(), border.corners.end(), corner), corner);
    ++border.added_corners;
  }
}

// Shares of the side's length at its vertices, 0 at the first.
std::vector<double> sharesAlong(const BorderPath& path, const Side& side) {
  const double edges = side.end - side.begin;
  const double least = kShortestEdge * (path.at(side.end) - path.at(side.begin)) / edges;
  std::vector<double> shares = {0};
  for (std::uint32_t i = side.begin; i < side.end; ++i)
    shares.push_back(shares.back() + std::max(path.at(i + 1) - path.at(i), least));
  for (double& share : shares) share /= shares.back();
  return shares;
}

// Puts the side's vertices, its end left out, on the chord from `a`, or on an arc over it that leaves it at
// the angle `bulge`.
void placeSide(const Side& side, const std::vector<double>& shares, const Vec2& a, const Vec2& chord,
               double bulge, std::vector<Vec2>& points) {
  const Vec2 outwards(chord.y(), -chord.x());  // as long as the chord
  for (std::uint32_t i = side.begin; i < side.end; ++i) {
    Vec2& point = points[i % points.size()];
    const double t = shares[i - side.begin];
    point = a + t * chord;
    if (bulge == 0 || i == side.begin) continue;
    const double phi = bulge * (2 * t - 1);
    // cos φ − cos bulge, without cancellation.
    const double rise = 2 * std::sin((bulge + phi) / 2) * std::sin((bulge - phi) / 2);
    point = a + chord / 2 + (std::sin(phi) * chord + rise * outwards) / (2 * std::sin(bulge));
  }
}

}  // namespace

double circumradius(std::span<const double> lengths) {
  const std::size_t longest =
      static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  // In units of the longest, and of x = longest ÷ diameter in (0, 1].
  const auto othersAngle = [&](double x) {
    double sum = 0;
    for (std::size_t i = 0; i < lengths.size(); ++i)
      if (i != longest) sum += std::asin(x * (lengths[i] / lengths[longest]));
    return sum;
  };
  // The centre is inside if the others reach around more than a half circle over the longest as diameter.
  const bool inside = othersAngle(1) >= std::numbers::pi / 2;
  const auto excess = [&](double x) {
    return inside ? othersAngle(x) + std::asin(x) - std::numbers::pi : std::asin(x) - othersAngle(x);
  };
  // Inside: grows from −π. Outside: negative where x is small, as the others are longer together.
  double low = 0, high = 1;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = (low + high) / 2;
    (excess(middle) < 0 ? low : high) = middle;
  }
  return lengths[longest] / (low + high);
}

ConvexBorder convexBorder(const Chart& chart, std::span<const std::uint32_t> chosen, int count) {
  const BorderPath path(chart);
  ConvexBorder border;
  border.corners = chosenCorners(path, chosen, chart.vertexCount());
  if (border.corners.empty()) border.corners = uniformCorners(path, count);
  const std::vector<Side> sides = closableSides(path, border);
  Notches notches = fillNotches(chart, path, sides);
  border.inside = std::move(notches.inside);
  border.notches = std::move(notches.triangles);

  std::vector<double> lengths;
  for (const Side& side : sides) lengths.push_back(side.length);
  const double radius = circumradius(lengths);
  std::vector<double> half_angles;  // as seen from the circle's centre
  for (const double length : lengths) half_angles.push_back(std::asin(std::min(length / (2 * radius), 1.0)));
  // Around an outside centre the longest side goes back over what the others went.
  const auto longest =
      static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  const double others = std::accumulate(half_angles.begin(), half_angles.end(), 0.0) - half_angles[longest];
  half_angles[longest] = std::numbers::pi - others;

  border.points.resize(path.size());
  Vec2 a = Vec2::Zero();
  double angle = 0;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    // Chord by chord, so that lengths are exact however large the radius.
    const Vec2 along(std::cos(angle + half_angles[k]), std::sin(angle + half_angles[k]));
    placeSide(sides[k], sharesAlong(path, sides[k]), a, lengths[k] * along,
              notches.sides_with_chords[k] ? std::min(half_angles[k], kLargestBulge_rad) : 0, border.points);
    border.bulged_sides += notches.sides_with_chords[k];
    a += lengths[k] * along;
    angle += 2 * half_angles[k];
  }
  return border;
}

}  // namespace bakelight::atlas
