#include "tools/atlas/convex_border.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <queue>
#include <utility>

namespace bakelight::atlas {
namespace {

constexpr double kLargestShare = 0.98;  // of a side, of the others together
constexpr double kLeastSlack =
    0.02;  // of the shortest side, by which the others exceed one that cannot be divided
constexpr double kShortestEdge = 1e-6;  // of a side ÷ its edges
constexpr double kLargestBulge_rad = std::numbers::pi / 6;
// A vertex may go inside if the border is reentrant there, or if it is about straight at the foot of a tooth.
constexpr double kReentrant_rad = 190 * std::numbers::pi / 180;
constexpr double kAboutStraight_rad = 150 * std::numbers::pi / 180;
constexpr std::uint32_t kEdgesOfTooth = 8;  // at most
constexpr double kWidestNotch_rad = 160 * std::numbers::pi / 180;
constexpr double kNarrowestNotch_rad = 10 * std::numbers::pi / 180;
constexpr std::uint32_t kNone = ~0u;

// The outer border with the path lengths from its first vertex; the last is the whole length.
struct BorderPath {
  const std::vector<std::uint32_t>& vertices;
  std::vector<double> length_to;

  explicit BorderPath(const Chart& chart) : vertices(chart.borders.front()), length_to{0} {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Vec3& next = chart.positions[vertices[(i + 1) % vertices.size()]];
      length_to.push_back(length_to.back() + (next - chart.positions[vertices[i]]).norm());
    }
  }
  std::uint32_t size() const { return static_cast<std::uint32_t>(vertices.size()); }
  // Of vertex i, which may have gone around once.
  double at(std::uint32_t i) const {
    return i < size() ? length_to[i] : length_to.back() + length_to[i - size()];
  }
};

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

// The border between two corners, as indices into it; `end` is larger than `begin` and may be past the
// border's end.
struct Side {
  std::uint32_t begin, end;
  double length;
};

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

// The border while notches are filled: which vertices are still on it, and the edges inside that join two of
// them.
class Outline {
 public:
  Outline(const Chart& chart, const BorderPath& path, const std::vector<Side>& sides)
      : path_(path),
        sides_(sides),
        side_of_(path.size()),
        next_(path.size()),
        previous_(path.size()),
        edge_length_(path.size()),
        angle_(path.size(), 0.0),
        inside_(path.size(), 0),
        is_corner_(path.size(), 0),
        chords_from_(path.size()) {
    for (std::uint32_t k = 0; k < sides.size(); ++k) {
      is_corner_[sides[k].begin] = 1;
      for (std::uint32_t i = sides[k].begin; i < sides[k].end; ++i) side_of_[i % path.size()] = k;
    }
    for (std::uint32_t i = 0; i < path.size(); ++i) {
      next_[i] = (i + 1) % path.size();
      previous_[next_[i]] = i;
      edge_length_[i] = path.at(i + 1) - path.at(i);
    }
    std::vector<std::uint32_t> place(chart.vertexCount(), kNone);
    for (std::uint32_t i = 0; i < path.size(); ++i) place[path.vertices[i]] = i;
    for (const Triangle& t : chart.triangles)
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const std::uint32_t a = place[t[corner]], b = place[t[(corner + 1) % 3]];
        if (a == kNone) continue;
        const Vec3 u = chart.positions[t[(corner + 1) % 3]] - chart.positions[t[corner]],
                   v = chart.positions[t[(corner + 2) % 3]] - chart.positions[t[corner]];
        angle_[a] += std::atan2(u.cross(v).norm(), u.dot(v));
        if (b != kNone && next_[a] != b && next_[b] != a) chords_.push_back({std::min(a, b), std::max(a, b)});
      }
    std::sort(chords_.begin(), chords_.end());
    chords_.erase(std::unique(chords_.begin(), chords_.end()), chords_.end());
    for (const auto& [a, b] : chords_) chords_from_[a].push_back(b), chords_from_[b].push_back(a);
  }

  // The most reentrant vertex first; filling its notch makes its neighbours more reentrant, too, so that bays
  // of many vertices fill up.
  void fillNotches(ConvexBorder& border) {
    std::priority_queue<std::pair<double, std::uint32_t>> queue;
    for (std::uint32_t i = 0; i < path_.size(); ++i) queue.emplace(angle_[i], i);
    while (!queue.empty()) {
      const auto [angle, i] = queue.top();
      queue.pop();
      if (angle != angle_[i] || !hasChordOnSide(i) || !canGoInside(i)) continue;
      border.notches.push_back(fill(i));
      for (const std::uint32_t neighbor : {previous_[i], next_[i]}) queue.emplace(angle_[neighbor], neighbor);
    }
    border.inside = inside_;
  }

  // For each side, whether an inner edge joins two of its vertices.
  std::vector<std::uint8_t> sidesWithChords() const {
    std::vector<std::uint8_t> result(sides_.size(), 0);
    for (const auto& [a, b] : chords_)
      if (const std::uint32_t side = commonSide(a, b); side != kNone) result[side] = 1;
    return result;
  }

 private:
  // The side that both lie on, or kNone. A corner belongs to the side that begins there, and to the one
  // before.
  std::uint32_t commonSide(std::uint32_t a, std::uint32_t b) const {
    if (inside_[a] || inside_[b]) return kNone;
    const auto isOn = [&](std::uint32_t i, std::uint32_t side) {
      return side_of_[i] == side || sides_[side].end % path_.size() == i;
    };
    for (const std::uint32_t side : {side_of_[a], side_of_[b]})
      if (isOn(a, side) && isOn(b, side)) return side;
    return kNone;
  }

  // Whether a chord ends there that would be gone with the vertex.
  bool hasChordOnSide(std::uint32_t i) const {
    const auto& others = chords_from_[i];
    return std::any_of(others.begin(), others.end(), [&](std::uint32_t other) {
      const std::uint32_t edges =
          std::min(i - other + (i < other ? path_.size() : 0), other - i + (other < i ? path_.size() : 0));
      return commonSide(i, other) != kNone &&
             angle_[i] >= (edges <= kEdgesOfTooth ? kAboutStraight_rad : kReentrant_rad);
    });
  }

  // Whether its neighbours may be joined by an edge.
  bool canGoInside(std::uint32_t i) const {
    const std::array<std::uint32_t, 2> ends = {std::min(previous_[i], next_[i]),
                                               std::max(previous_[i], next_[i])};
    return !is_corner_[i] && !std::binary_search(chords_.begin(), chords_.end(), ends);
  }

  NotchTriangle fill(std::uint32_t i) {
    const std::uint32_t before = previous_[i], after = next_[i];
    const double angle = std::clamp(2 * std::numbers::pi - angle_[i], kNarrowestNotch_rad, kWidestNotch_rad);
    const NotchTriangle notch = {{path_.vertices[i], path_.vertices[before], path_.vertices[after]},
                                 {Vec2(0, 0), Vec2(edge_length_[before], 0),
                                  edge_length_[i] * Vec2(std::cos(angle), std::sin(angle))}};
    const auto& [apex, left, right] = notch.shape;
    const auto angleBetween = [](const Vec2& u, const Vec2& v) {
      return std::acos(std::clamp(u.dot(v) / (u.norm() * v.norm()), -1.0, 1.0));
    };
    angle_[before] += angleBetween(apex - left, right - left);
    angle_[after] += angleBetween(apex - right, left - right);
    edge_length_[before] = (right - left).norm();
    next_[before] = after;
    previous_[after] = before;
    inside_[i] = 1;
    return notch;
  }

  const BorderPath& path_;
  const std::vector<Side>& sides_;
  std::vector<std::uint32_t> side_of_, next_, previous_;
  std::vector<double> edge_length_;  // to the next
  std::vector<double> angle_;        // of the triangles around each vertex
  std::vector<std::uint8_t> inside_, is_corner_;
  std::vector<std::array<std::uint32_t, 2>> chords_;     // ascending
  std::vector<std::vector<std::uint32_t>> chords_from_;  // the other ends
};

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
  Outline outline(chart, path, sides);
  outline.fillNotches(border);
  const std::vector<std::uint8_t> has_chord = outline.sidesWithChords();

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
              has_chord[k] ? std::min(half_angles[k], kLargestBulge_rad) : 0, border.points);
    border.bulged_sides += has_chord[k];
    a += lengths[k] * along;
    angle += 2 * half_angles[k];
  }
  return border;
}

}  // namespace bakelight::atlas
