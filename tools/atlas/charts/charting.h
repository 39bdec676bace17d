// From a surface to charts that lie flat, one-to-one and with little distortion.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/atlas/flatten/flattening.h"

namespace bakelight::atlas {

struct ChartingOptions {
  FlatteningOptions flattening;
  // Charts are the connected parts that cuts leave, divided only where they cannot be laid flat one-to-one.
  bool cuts_only = false;

  // What follows shapes automatic charts; it does not apply to `cuts_only`.
  double pieces = 14;          // to begin with, for the whole area
  double solidity = 0.87;      // least area ÷ area of the convex hull in the plane that merging may make
  double largest_share = 0.3;  // of the whole area, that merging may make
  // Merging ends when it has laid so many times all triangles flat, or a 20th of that beside what a proxy has
  // merged: effort is counted, never timed.
  double merging_effort = 40;
  // Surfaces of many more triangles are charted on a proxy of so many or a 16th first (proxy.h).
  std::size_t proxy_triangles = 24'000;
};

struct ChartingReport {
  std::int64_t regions = 0, first_pieces = 0, splits = 0, merges = 0, merges_tried = 0;
  std::int64_t proxy_triangles = 0;   // 0: there was no need of one
  std::int64_t triangles_tried = 0;   // that merging laid flat, in all
  bool is_merging_cut_short = false;  // more might be possible
};

// Segmentation (segmentation.h) within what creases separate, flattening, halving of what does not lie flat,
// then merging of neighbours as long as they lie flat together, longest common borders first; by way of a
// proxy, small pieces before large ones, and scraps join their neighbours untried. Charts cover every
// triangle once and are ordered by their first triangles. Deterministic; threads by TBB.
std::vector<FlatPiece> makeCharts(const Surface& surface, const ChartingOptions& options,
                                  ChartingReport& report);

// Divides the pieces at `indices`, ascending, in two, lays the parts flat, and returns all pieces in the same
// order as makeCharts.
std::vector<FlatPiece> divideCharts(const Surface& surface, std::vector<FlatPiece> pieces,
                                    std::span<const std::size_t> indices, const ChartingOptions& options,
                                    ChartingReport& report);

}  // namespace bakelight::atlas
