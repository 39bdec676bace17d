// Moves overlapping charts until they overlap no more: guided local search over placements, each move an
// exact search along lines.
//
// The search is that of Egeblad, Nielsen & Odgaard 2007, "Fast neighborhood search for two- and
// three-dimensional nesting problems" (overlap along a line of translation is piecewise linear, so its
// least is found in one sweep), with weights of pairs and their growth as in Gardeyn & Vanden Berghe 2025,
// "An open-source heuristic to reboot 2D nesting research".
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tools/atlas/packing/turned_masks.h"

namespace bakelight::atlas {

// Where a chart lies in a square of any size and fineness.
struct Spot {
  double turn = 0;             // of a full circle from upright
  Vec2 middle = Vec2::Zero();  // of the chart's box before it was turned ÷ the square's side
};

struct Pose {
  int turn = 0;
  int x = 0, y = 0;  // where the mask's box begins
};

class Separation {
 public:
  // A square of `side` texels. Both masks and this change as masks are asked for.
  Separation(TurnedMasks& masks, int side, std::uint64_t seed);

  // How a chart is moved: along a line through its place in each of some turns, and along some lines anywhere
  // in any turn, then on along lines across as long as that helps.
  struct Moves {
    std::vector<int> turns;  // relative to the present one, about the chart's middle
    int reach = 0;           // texels: of the lines through its place, to either side
    int random_lines = 0;
  };

  // Places the charts one after the other, each where it overlaps those before the least. False if one does
  // not fit into the square in any turn.
  bool placeAll(std::span<const std::uint32_t> order, int lines_each);
  // Places the charts as near to the spots as they lie inside the square, turned a little if they must be.
  // False if one does not fit.
  bool placeAt(std::span<const Spot> spots);
  std::vector<Spot> spots();
  // In texels of the square.
  Placement placementOf(std::size_t chart);
  // The same with a new side: false, and nothing is changed, if a chart does not fit.
  bool setSide(int side);

  // True once no two charts overlap; false after `patience` passes without less overlap than ever, or past
  // `work_limit`: then the charts lie as they did with the least overlap.
  bool separate(const Moves& moves, int patience, std::int64_t work_limit);
  // Each takes the middle of the other.
  void swapPlaces(std::size_t a, std::size_t b);

  std::int64_t work() const { return work_; }  // rows of masks compared so far
  std::uint64_t random(std::uint64_t below);   // 0 … below − 1

 private:
  struct Candidate {
    std::int64_t cost = 0;
    Pose pose;
  };
  enum class Axis { kX, kY };

  std::int64_t& overlapOf(std::size_t a, std::size_t b) { return overlaps_[a * masks_.charts() + b]; }
  std::int64_t& weightOf(std::size_t a, std::size_t b) { return weights_[a * masks_.charts() + b]; }
  const TurnedMask& maskOf(std::size_t chart) { return masks_.at(chart, poses_[chart].turn); }
  std::int64_t pairOverlap(std::size_t a, std::size_t b);
  std::int64_t weightedOverlap(std::size_t chart);
  void updateOverlaps(std::size_t chart);
  void updateAllOverlaps();
  // With the chart's middle as near to `middle` (texels) as it is inside, turned by up to a 32nd of a circle
  // if it does not fit otherwise.
  std::optional<Pose> poseAbout(std::size_t chart, const Vec2& middle, int turn);
  Vec2 middleOf(std::size_t chart) { return Vec2(poses_[chart].x, poses_[chart].y) + maskOf(chart).middle; }
  Candidate leastOnLine(std::size_t chart, const Pose& pose, Axis axis, int reach);
  Candidate descended(std::size_t chart, Candidate from, Axis last_axis, int reach);
  Candidate bestOfRandomLines(std::size_t chart, int lines);
  void relocate(std::size_t chart, const Moves& moves);
  void reweigh();

  TurnedMasks& masks_;
  int side_;
  std::uint64_t random_state_;
  std::vector<Pose> poses_;
  std::vector<std::uint8_t> placed_;    // charts that others are kept away from
  std::vector<std::int64_t> overlaps_;  // charts × charts, texels
  std::vector<std::int64_t> weights_;   // charts × charts, 1 / kUnitWeight
  std::int64_t total_overlap_ = 0;
  std::int64_t work_ = 0;
  std::vector<std::int64_t> bends_;  // of the overlap along a line: second differences
};

}  // namespace bakelight::atlas
