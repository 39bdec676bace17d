#include "tools/atlas/packing/separation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "transport/random.h"

namespace bakelight::atlas {
namespace {

constexpr std::int64_t kUnitWeight = 16, kGreatestWeight = 1 << 20;
constexpr std::int64_t kNoPlace = std::numeric_limits<std::int64_t>::max();

// Calls f(span of a, span of b) for the spans of rows in common, b moved by (dx, dy) relative to a; returns
// the number of rows.
template <class Function>
int forSpanPairs(const TexelMask& a, const TexelMask& b, int dy, const Function& f) {
  const int begin = std::max(0, dy), end = std::min(a.height, b.height + dy);
  for (int r = begin; r < end; ++r) {
    const std::uint32_t a_end = a.row_begins[r + 1], b_begin = b.row_begins[r - dy],
                        b_end = b.row_begins[r - dy + 1];
    for (std::uint32_t i = a.row_begins[r]; i < a_end; ++i)
      for (std::uint32_t j = b_begin; j < b_end; ++j) f(a.spans[i], b.spans[j]);
  }
  return std::max(0, end - begin);
}

bool fits(const TurnedMask& mask, int side) {
  return mask.rows.width <= side && mask.rows.height <= side;
}

}  // namespace

Separation::Separation(TurnedMasks& masks, int side, std::uint64_t seed)
    : masks_(masks),
      side_(side),
      random_state_(transport::scrambled(seed)),
      poses_(masks.charts()),
      placed_(masks.charts(), 1),
      overlaps_(masks.charts() * masks.charts(), 0),
      weights_(masks.charts() * masks.charts(), kUnitWeight) {}

std::uint64_t Separation::random(std::uint64_t below) {
  random_state_ = transport::scrambled(random_state_);
  return random_state_ % below;
}

std::optional<Pose> Separation::poseAbout(std::size_t chart, const Vec2& middle, int turn) {
  const int turns = masks_.turns();
  const int tries = std::min(turns, std::max(8, turns / 16));
  for (int i = 0; i < tries; ++i) {
    // 0, 1, −1, 2, −2 … from the turn that is asked for.
    const int t = turn + (i % 2 == 1 ? (i + 1) / 2 : -(i / 2));
    const int wrapped = (t % turns + turns) % turns;
    const TurnedMask& mask = masks_.at(chart, wrapped);
    if (!fits(mask, side_)) continue;
    const Vec2 corner = middle - mask.middle;
    return Pose{wrapped, std::clamp(static_cast<int>(std::lround(corner.x())), 0, side_ - mask.rows.width),
                std::clamp(static_cast<int>(std::lround(corner.y())), 0, side_ - mask.rows.height)};
  }
  return std::nullopt;
}

bool Separation::placeAt(std::span<const Spot> spots) {
  std::vector<Pose> poses(spots.size());
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const auto pose =
        poseAbout(i, side_ * spots[i].middle, static_cast<int>(std::lround(spots[i].turn * masks_.turns())));
    if (!pose) return false;
    poses[i] = *pose;
  }
  poses_ = std::move(poses);
  updateAllOverlaps();
  return true;
}

std::vector<Spot> Separation::spots() {
  std::vector<Spot> spots(poses_.size());
  for (std::size_t i = 0; i < spots.size(); ++i)
    spots[i] = {static_cast<double>(poses_[i].turn) / masks_.turns(), middleOf(i) / side_};
  return spots;
}

Placement Separation::placementOf(std::size_t chart) {
  const TurnedMask& mask = maskOf(chart);
  return {mask.angle_rad, mask.offset + Vec2(poses_[chart].x, poses_[chart].y)};
}

bool Separation::setSide(int side) {
  const int old_side = std::exchange(side_, side);
  std::vector<Spot> moved(poses_.size());
  for (std::size_t i = 0; i < moved.size(); ++i)
    moved[i] = {static_cast<double>(poses_[i].turn) / masks_.turns(), middleOf(i) / side};
  if (placeAt(moved)) return true;
  side_ = old_side;
  return false;
}

void Separation::swapPlaces(std::size_t a, std::size_t b) {
  const Vec2 middle_a = middleOf(a), middle_b = middleOf(b);
  // They have poses in this square already, so some turn fits.
  poses_[a] = *poseAbout(a, middle_b, poses_[a].turn);
  poses_[b] = *poseAbout(b, middle_a, poses_[b].turn);
  updateAllOverlaps();
}

std::int64_t Separation::pairOverlap(std::size_t a, std::size_t b) {
  if (!placed_[a] || !placed_[b]) return 0;
  const TexelMask &mask_a = maskOf(a).rows, &mask_b = maskOf(b).rows;
  const int dx = poses_[b].x - poses_[a].x, dy = poses_[b].y - poses_[a].y;
  if (dx >= mask_a.width || -dx >= mask_b.width) return 0;
  int overlap = 0;
  work_ += forSpanPairs(mask_a, mask_b, dy, [&](const Span& s, const Span& t) {
    overlap += std::max(0, std::min(s.end, t.end + dx) - std::max(s.begin, t.begin + dx));
  });
  return overlap;
}

void Separation::updateOverlaps(std::size_t chart) {
  for (std::size_t other = 0; other < masks_.charts(); ++other) {
    if (other == chart) continue;
    const std::int64_t overlap = pairOverlap(chart, other);
    total_overlap_ += overlap - overlapOf(chart, other);
    overlapOf(chart, other) = overlapOf(other, chart) = overlap;
  }
}

void Separation::updateAllOverlaps() {
  total_overlap_ = 0;
  for (std::size_t a = 0; a < masks_.charts(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      total_overlap_ += overlapOf(a, b) = overlapOf(b, a) = pairOverlap(a, b);
}

std::int64_t Separation::weightedOverlap(std::size_t chart) {
  std::int64_t sum = 0;
  for (std::size_t other = 0; other < masks_.charts(); ++other)
    sum += weightOf(chart, other) * overlapOf(chart, other);
  return sum;
}

Separation::Candidate Separation::leastOnLine(std::size_t chart, const Pose& pose, Axis axis, int reach) {
  const bool along_x = axis == Axis::kX;
  const TurnedMask& turned_mask = masks_.at(chart, pose.turn);
  const TexelMask& mask = along_x ? turned_mask.rows : turned_mask.columns;
  const int across = along_x ? pose.y : pose.x, along = along_x ? pose.x : pose.y;
  const int first = std::max(0, along - reach), last = std::min(side_ - mask.width, along + reach);

  // With the chart at −width nothing overlaps. A pair of spans [b, e) and [c, d) overlaps by a trapezoid of
  // the chart's place: from c − e upwards, level from one of c − b and d − e to the other, down to d − b.
  bends_.assign(static_cast<std::size_t>(side_ + mask.width) + 1, 0);
  std::int64_t* const bends = bends_.data() + mask.width;
  int begin = first;
  for (std::size_t other = 0; other < masks_.charts(); ++other) {
    if (other == chart || !placed_[other]) continue;
    const TurnedMask& other_mask = maskOf(other);
    const TexelMask& fixed = along_x ? other_mask.rows : other_mask.columns;
    const int at = along_x ? poses_[other].x : poses_[other].y;
    if (at >= last + mask.width || at + fixed.width <= first) continue;
    begin = std::min(begin, at - mask.width);
    const int offset_across = (along_x ? poses_[other].y : poses_[other].x) - across;
    const std::int64_t weight = weightOf(chart, other);
    work_ += forSpanPairs(mask, fixed, offset_across, [&](const Span& s, const Span& t) {
      std::int64_t* const b = bends + at;
      b[t.begin - s.end] += weight;
      b[t.begin - s.begin] -= weight;
      b[t.end - s.end] -= weight;
      b[t.end - s.begin] += weight;
    });
  }
  std::int64_t slope = 0, cost = 0;
  for (int x = begin; x < first; ++x) cost += slope += bends[x];
  // Of equal places one at an end of a run: there the chart touches another or a side.
  const bool take_last = random(2) == 1;
  Candidate best{kNoPlace, pose};
  int best_x = along;
  for (int x = first; x <= last; ++x) {
    if (cost < best.cost || (take_last && cost == best.cost)) best.cost = cost, best_x = x;
    cost += slope += bends[x];
  }
  (along_x ? best.pose.x : best.pose.y) = best_x;
  return best;
}

// Alternates between the two lines through the place as long as that helps.
Separation::Candidate Separation::descended(std::size_t chart, Candidate from, Axis last_axis, int reach) {
  for (int i = 0; i < 6 && from.cost > 0; ++i) {
    last_axis = last_axis == Axis::kX ? Axis::kY : Axis::kX;
    const Candidate next = leastOnLine(chart, from.pose, last_axis, reach);
    if (next.cost >= from.cost) break;
    from = next;
  }
  return from;
}

Separation::Candidate Separation::bestOfRandomLines(std::size_t chart, int lines) {
  Candidate best{kNoPlace, {}};
  for (int line = 0; line < lines; ++line) {
    Pose pose;
    pose.turn = static_cast<int>(random(masks_.turns()));
    // A long chart fits in few of its turns.
    for (int i = 0; i < masks_.turns() && !fits(masks_.at(chart, pose.turn), side_); ++i)
      pose.turn = (pose.turn + 1) % masks_.turns();
    const TexelMask& mask = masks_.at(chart, pose.turn).rows;
    if (!fits(masks_.at(chart, pose.turn), side_)) break;
    pose.x = static_cast<int>(random(side_ - mask.width + 1));
    pose.y = static_cast<int>(random(side_ - mask.height + 1));
    const Axis axis = random(2) == 1 ? Axis::kX : Axis::kY;
    const Candidate candidate = descended(chart, leastOnLine(chart, pose, axis, side_), axis, side_);
    if (candidate.cost < best.cost) best = candidate;
  }
  return best;
}

bool Separation::placeAll(std::span<const std::uint32_t> order, int lines_each) {
  std::fill(placed_.begin(), placed_.end(), std::uint8_t{0});
  for (const std::uint32_t chart : order) {
    const Candidate candidate = bestOfRandomLines(chart, lines_each);
    if (candidate.cost == kNoPlace) return false;
    poses_[chart] = candidate.pose;
    placed_[chart] = 1;
  }
  updateAllOverlaps();
  return true;
}

void Separation::relocate(std::size_t chart, const Moves& moves) {
  Candidate best{weightedOverlap(chart), poses_[chart]};
  for (const int turn : moves.turns) {
    const Pose pose = *poseAbout(chart, middleOf(chart), poses_[chart].turn + turn);
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      const Candidate candidate =
          descended(chart, leastOnLine(chart, pose, axis, moves.reach), axis, moves.reach);
      if (candidate.cost < best.cost) best = candidate;
    }
  }
  if (best.cost > 0) {
    const Candidate candidate = bestOfRandomLines(chart, moves.random_lines);
    if (candidate.cost < best.cost) best = candidate;
  }
  poses_[chart] = best.pose;
  updateOverlaps(chart);
}

// Pairs that overlap get heavier, by how much they do; the others slowly forget.
void Separation::reweigh() {
  const std::int64_t greatest = *std::max_element(overlaps_.begin(), overlaps_.end());
  for (std::size_t i = 0; i < weights_.size(); ++i)
    if (overlaps_[i] > 0)
      weights_[i] =
          std::min(kGreatestWeight, weights_[i] * 12 / 10 + weights_[i] * 8 * overlaps_[i] / (10 * greatest));
    else
      weights_[i] = std::max(kUnitWeight, weights_[i] * 95 / 100);
}

bool Separation::separate(const Moves& moves, int patience, std::int64_t work_limit) {
  std::fill(weights_.begin(), weights_.end(), kUnitWeight);
  std::vector<Pose> least_poses = poses_;
  std::int64_t least = total_overlap_;
  std::vector<std::uint32_t> colliding;
  for (int stale = 0; total_overlap_ > 0 && stale < patience && work_ < work_limit; ++stale) {
    colliding.clear();
    for (std::uint32_t i = 0; i < masks_.charts(); ++i)
      if (weightedOverlap(i) > 0) colliding.push_back(i);
    for (std::size_t i = colliding.size(); i > 1; --i) std::swap(colliding[i - 1], colliding[random(i)]);
    for (const std::uint32_t chart : colliding)
      if (weightedOverlap(chart) > 0) relocate(chart, moves);
    if (total_overlap_ < least) {
      least = total_overlap_;
      least_poses = poses_;
      stale = 0;
    }
    reweigh();
  }
  if (total_overlap_ == 0) return true;
  poses_ = std::move(least_poses);
  updateAllOverlaps();
  return false;
}

}  // namespace bakelight::atlas
