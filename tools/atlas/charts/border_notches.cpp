#include "tools/atlas/charts/border_notches.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <utility>

namespace bakelight::atlas {
namespace {

// A vertex may go inside if the border is reentrant there, or if it is about straight at the foot of a tooth.
constexpr double kReentrant_rad = 190 * std::numbers::pi / 180;
constexpr double kAboutStraight_rad = 150 * std::numbers::pi / 180;
constexpr std::uint32_t kEdgesOfTooth = 8;  // at most
constexpr double kWidestNotch_rad = 160 * std::numbers::pi / 180;
constexpr double kNarrowestNotch_rad = 10 * std::numbers::pi / 180;
constexpr std::uint32_t kNone = ~0u;

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
  Notches fill() {
    Notches notches;
    std::priority_queue<std::pair<double, std::uint32_t>> queue;
    for (std::uint32_t i = 0; i < path_.size(); ++i) queue.emplace(angle_[i], i);
    while (!queue.empty()) {
      const auto [angle, i] = queue.top();
      queue.pop();
      if (angle != angle_[i] || !hasChordOnSide(i) || !canGoInside(i)) continue;
      notches.triangles.push_back(fillAt(i));
      for (const std::uint32_t neighbor : {previous_[i], next_[i]}) queue.emplace(angle_[neighbor], neighbor);
    }
    notches.inside = inside_;
    notches.sides_with_chords = sidesWithChords();
    return notches;
  }

 private:
  // For each side, whether an inner edge joins two of its vertices.
  std::vector<std::uint8_t> sidesWithChords() const {
    std::vector<std::uint8_t> result(sides_.size(), 0);
    for (const auto& [a, b] : chords_)
      if (const std::uint32_t side = commonSide(a, b); side != kNone) result[side] = 1;
    return result;
  }

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

  NotchTriangle fillAt(std::uint32_t i) {
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

}  // namespace

Notches fillNotches(const Chart& chart, const BorderPath& path, const std::vector<Side>& sides) {
  return Outline(chart, path, sides).fill();
}

}  // namespace bakelight::atlas
