#include "tools/atlas/charting.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>

#include "tools/atlas/free_boundary.h"
#include "tools/atlas/injectivity.h"
#include "tools/atlas/segmentation.h"

namespace bakelight::atlas {
namespace {

using TriangleSet = std::vector<std::uint32_t>;

double perimeterOf(const Chart& chart) {
  double sum = 0;
  for (const auto& loop : chart.borders)
    for (std::size_t i = 0; i < loop.size(); ++i)
      sum += (chart.positions[loop[i]] - chart.positions[loop[(i + 1) % loop.size()]]).norm();
  return sum;
}

// Area ÷ area of the convex hull: near 1 for shapes that pack well.
double solidityOf(const FlatPiece& piece) {
  std::vector<Vec2> points;
  for (const std::uint32_t v : piece.chart.borders[0]) points.push_back(piece.plane[v]);
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  // Andrew's monotone chain: the lower hull, then the upper one.
  double twice_area = 0;
  for (int side = 0; side < 2; ++side) {
    std::vector<Vec2> hull;
    for (const Vec2& p : points) {
      while (hull.size() >= 2 && crossOf(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    for (std::size_t i = 0; i + 1 < hull.size(); ++i) twice_area += hull[i].x() * hull[i + 1].y() - hull[i].y() * hull[i + 1].x();
    std::reverse(points.begin(), points.end());
  }
  return piece.stretch.plane_area / (twice_area / 2);
}

// Nothing if the triangles cannot be laid flat one-to-one within the stretch.
std::optional<FlatPiece> flatten(const Surface& surface, const TriangleSet& triangles, double max_stretch) {
  FlatPiece piece;
  piece.chart = chartOf(surface, triangles);
  auto start = flatStart(piece.chart);
  if (!start) return std::nullopt;
  piece.plane = minimiseDistortion(piece.chart, std::move(*start));
  piece.stretch = stretchOf(piece.chart, piece.plane);
  if (triangles.size() > 1 && !(piece.stretch.l2() <= max_stretch)) return std::nullopt;
  if (!isInjective(piece.chart, piece.plane)) return std::nullopt;
  return piece;
}

struct Piece {
  TriangleSet triangles;
  std::int32_t region = 0;
  std::optional<FlatPiece> flat;
  double perimeter = 0;
};

class Charting {
 public:
  Charting(const Surface& surface, const ChartingOptions& options, ChartingReport& report)
      : surface_(surface), options_(options), report_(report) {}

  std::vector<FlatPiece> run() {
    divide();
    settle();
    merge();
    straighten();
    settle();
    std::vector<FlatPiece> result;
    for (Piece& piece : pieces_) result.push_back(std::move(*piece.flat));
    return result;
  }

 private:
  void divide() {
    const auto parts = smoothParts(surface_);
    report_.regions = static_cast<std::int64_t>(parts.size());
    regions_.resize(surface_.triangleCount());
    std::vector<std::vector<Piece>> made(parts.size());
    for (std::size_t r = 0; r < parts.size(); ++r)
      for (const std::uint32_t t : parts[r]) regions_[t] = static_cast<std::int32_t>(r);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t r) {
      double area = 0;
      for (const std::uint32_t t : parts[r]) area += surface_.areas[t];
      const int count = std::max(1, static_cast<int>(std::lround(options_.pieces * area)));
      if (count == 1) {
        made[r].push_back({parts[r], static_cast<std::int32_t>(r), {}, 0});
        return;
      }
      for (TriangleSet& set : divided(parts[r], count)) made[r].push_back({std::move(set), static_cast<std::int32_t>(r), {}, 0});
    });
    for (auto& region : made)
      for (Piece& piece : region) pieces_.push_back(std::move(piece));
    report_.first_pieces = static_cast<std::int64_t>(pieces_.size());
    straighten();
  }

  std::vector<TriangleSet> divided(const TriangleSet& triangles, int count) const {
    const std::vector<std::int32_t> labels = cluster(surface_, triangles, count);
    std::vector<TriangleSet> sets(static_cast<std::size_t>(*std::max_element(labels.begin(), labels.end())) + 1);
    for (std::size_t i = 0; i < triangles.size(); ++i) sets[labels[i]].push_back(triangles[i]);
    return sets;
  }

  void straighten() {
    std::vector<std::int32_t> labels(surface_.triangleCount());
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      for (const std::uint32_t t : pieces_[p].triangles) labels[t] = static_cast<std::int32_t>(p);
    straightenBorders(surface_, regions_, labels);
    std::vector<TriangleSet> sets(pieces_.size());
    for (std::uint32_t t = 0; t < labels.size(); ++t) sets[labels[t]].push_back(t);
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      if (sets[p] != pieces_[p].triangles) pieces_[p].triangles = std::move(sets[p]), pieces_[p].flat.reset();
    std::erase_if(pieces_, [](const Piece& piece) { return piece.triangles.empty(); });
  }

  // Flattens what is not flat, halves what cannot be, until all are.
  void settle() {
    std::vector<Piece> done, open;
    for (Piece& piece : pieces_) (piece.flat ? done : open).push_back(std::move(piece));
    while (!open.empty()) {
      std::vector<std::vector<Piece>> next(open.size());
      tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t i) {
        Piece& piece = open[i];
        piece.flat = flatten(surface_, piece.triangles, options_.max_stretch);
        if (piece.flat) {
          piece.perimeter = perimeterOf(piece.flat->chart);
          return;
        }
        for (TriangleSet& set : divided(piece.triangles, 2)) next[i].push_back({std::move(set), piece.region, {}, 0});
      });
      std::vector<Piece> halves;
      for (std::size_t i = 0; i < open.size(); ++i) {
        if (open[i].flat) done.push_back(std::move(open[i]));
        report_.splits += next[i].empty() ? 0 : 1;
        for (Piece& half : next[i]) halves.push_back(std::move(half));
      }
      open = std::move(halves);
    }
    std::sort(done.begin(), done.end(), [](const Piece& a, const Piece& b) { return a.triangles[0] < b.triangles[0]; });
    pieces_ = std::move(done);
  }

  struct Candidate {
    double share;  // of the smaller perimeter
    std::size_t a, b;
  };

  std::vector<Candidate> candidates(const std::set<std::pair<std::uint32_t, std::uint32_t>>& refused) const {
    std::vector<std::size_t> piece_of(surface_.triangleCount());
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      for (const std::uint32_t t : pieces_[p].triangles) piece_of[t] = p;
    std::map<std::pair<std::size_t, std::size_t>, double> shared;
    for (std::size_t t = 0; t < surface_.triangleCount(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t other = surface_.passable(t, k);
        if (other < 0 || piece_of[other] <= piece_of[t] || regions_[other] != regions_[t]) continue;
        shared[{piece_of[t], piece_of[other]}] += (surface_.corner(t, (k + 1) % 3) - surface_.corner(t, k)).norm();
      }
    std::vector<Candidate> result;
    for (const auto& [pair, length] : shared) {
      const Piece &a = pieces_[pair.first], &b = pieces_[pair.second];
      if (refused.contains({identity(a), identity(b)})) continue;
      const double perimeter = a.perimeter + b.perimeter - 2 * length;
      const double area = a.flat->chart.area + b.flat->chart.area;
      if (area > options_.largest_share) continue;
      if (perimeter * perimeter > options_.roundness * 4 * std::numbers::pi * area) continue;
      result.push_back({length / std::min(a.perimeter, b.perimeter), pair.first, pair.second});
    }
    std::stable_sort(result.begin(), result.end(), [](const Candidate& a, const Candidate& b) { return a.share > b.share; });
    return result;
  }

  // A piece never changes its first triangle without being renamed: `born` counts.
  static std::uint32_t identity(const Piece& piece) { return piece.triangles[0] * 31 + static_cast<std::uint32_t>(piece.triangles.size()); }

  void merge() {
    std::set<std::pair<std::uint32_t, std::uint32_t>> refused;
    while (true) {
      std::vector<std::uint8_t> taken(pieces_.size(), 0);
      std::vector<Candidate> chosen;
      for (const Candidate& candidate : candidates(refused)) {
        if (taken[candidate.a] || taken[candidate.b]) continue;
        taken[candidate.a] = taken[candidate.b] = 1;
        chosen.push_back(candidate);
      }
      if (chosen.empty()) return;
      std::vector<std::optional<FlatPiece>> merged(chosen.size());
      tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t i) {
        TriangleSet both;
        const TriangleSet &a = pieces_[chosen[i].a].triangles, &b = pieces_[chosen[i].b].triangles;
        std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
        merged[i] = flatten(surface_, both, options_.max_stretch);
        if (merged[i] && solidityOf(*merged[i]) < options_.solidity) merged[i].reset();
      });
      std::vector<std::uint8_t> gone(pieces_.size(), 0);
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        ++report_.merges_tried;
        Piece &a = pieces_[chosen[i].a], &b = pieces_[chosen[i].b];
        if (!merged[i]) {
          refused.insert({identity(a), identity(b)});
          continue;
        }
        ++report_.merges;
        a.triangles = merged[i]->chart.surface_triangles;
        a.perimeter = perimeterOf(merged[i]->chart);
        a.flat = std::move(merged[i]);
        gone[chosen[i].b] = 1;
      }
      std::vector<Piece> left;
      for (std::size_t p = 0; p < pieces_.size(); ++p)
        if (!gone[p]) left.push_back(std::move(pieces_[p]));
      pieces_ = std::move(left);
    }
  }

  const Surface& surface_;
  const ChartingOptions& options_;
  ChartingReport& report_;
  std::vector<std::int32_t> regions_;
  std::vector<Piece> pieces_;
};

}  // namespace

std::vector<FlatPiece> makeCharts(const Surface& surface, const ChartingOptions& options, ChartingReport& report) {
  return Charting(surface, options, report).run();
}

}  // namespace bakelight::atlas
