#include "tools/atlas/charting.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

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
    for (std::size_t i = 0; i + 1 < hull.size(); ++i)
      twice_area += crossOf(Vec2::Zero(), hull[i], hull[i + 1]);
    std::reverse(points.begin(), points.end());
  }
  return piece.stretch.plane_area / (twice_area / 2);
}

struct Piece {
  TriangleSet triangles;
  std::int32_t region = 0;
  std::uint32_t id = 0;  // no two pieces ever have the same
  std::optional<FlatPiece> flat;
  double perimeter = 0;
};

struct Neighbors {
  std::size_t a, b;  // pieces
  double shared;     // length of the common border ÷ the smaller perimeter
};

class Charting {
 public:
  Charting(const Surface& surface, const ChartingOptions& options, ChartingReport& report)
      : surface_(surface), options_(options), report_(report) {}

  std::vector<FlatPiece> run() {
    findRegions();
    if (!options_.cuts_only) {
      divideRegions();
      straighten();
      settle();
      merge();
      // Straight borders would bring triangles with them that cannot be projected.
      if (options_.flattening.parameterisation != Parameterisation::kProjection) straighten();
    }
    settle();
    return flatPieces();
  }

  std::vector<FlatPiece> runOn(std::vector<FlatPiece> pieces, std::span<const std::size_t> to_divide) {
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const TriangleSet& triangles = pieces[p].chart.surface_triangles;
      if (std::binary_search(to_divide.begin(), to_divide.end(), p) && triangles.size() > 1) {
        ++report_.splits;
        for (TriangleSet& part : divided(triangles, 2)) add(std::move(part), 0);
      } else {
        add(triangles, 0);
        pieces_.back().flat = std::move(pieces[p]);
      }
    }
    settle();
    return flatPieces();
  }

 private:
  std::vector<FlatPiece> flatPieces() {
    tbb::parallel_for(std::size_t{0}, pieces_.size(),
                      [&](std::size_t p) { straightenTeeth(*pieces_[p].flat, options_.flattening); });
    std::vector<FlatPiece> result;
    result.reserve(pieces_.size());
    for (Piece& piece : pieces_) result.push_back(std::move(*piece.flat));
    return result;
  }

  void add(TriangleSet triangles, std::int32_t region) {
    Piece& piece = pieces_.emplace_back();
    piece.triangles = std::move(triangles);
    piece.region = region;
    piece.id = next_id_++;
  }

  void findRegions() {
    regions_.assign(surface_.triangleCount(), 0);
    const auto parts = options_.cuts_only ? connectedParts(surface_, regions_) : smoothParts(surface_);
    report_.regions = static_cast<std::int64_t>(parts.size());
    for (std::size_t r = 0; r < parts.size(); ++r) {
      for (const std::uint32_t t : parts[r]) regions_[t] = static_cast<std::int32_t>(r);
      add(parts[r], static_cast<std::int32_t>(r));
    }
  }

  std::vector<TriangleSet> divided(const TriangleSet& triangles, int count) const {
    const std::vector<std::int32_t> labels = cluster(surface_, triangles, count);
    std::vector<TriangleSet> sets(static_cast<std::size_t>(*std::max_element(labels.begin(), labels.end())) +
                                  1);
    for (std::size_t i = 0; i < triangles.size(); ++i) sets[labels[i]].push_back(triangles[i]);
    return sets;
  }

  // Regions that lie flat well as they are stay whole; the others become as many pieces as their share of the
  // area asks for.
  void divideRegions() {
    std::vector<std::vector<TriangleSet>> made(pieces_.size());
    tbb::parallel_for(std::size_t{0}, pieces_.size(), [&](std::size_t p) {
      double area = 0;
      for (const std::uint32_t t : pieces_[p].triangles) area += surface_.areas[t];
      const int count = static_cast<int>(std::lround(options_.pieces * area));
      if (count <= 1) return;
      auto whole = flatten(surface_, pieces_[p].triangles, options_.flattening);
      if (whole && solidityOf(*whole) >= options_.solidity)
        pieces_[p].flat = std::move(whole);
      else
        made[p] = divided(pieces_[p].triangles, count);
    });
    std::vector<Piece> regions = std::move(pieces_);
    pieces_.clear();
    for (std::size_t p = 0; p < regions.size(); ++p) {
      if (made[p].empty()) pieces_.push_back(std::move(regions[p]));
      for (TriangleSet& set : made[p]) add(std::move(set), regions[p].region);
    }
    report_.first_pieces = static_cast<std::int64_t>(pieces_.size());
  }

  void straighten() {
    std::vector<std::int32_t> labels(surface_.triangleCount());
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      for (const std::uint32_t t : pieces_[p].triangles) labels[t] = static_cast<std::int32_t>(p);
    straightenBorders(surface_, regions_, labels);
    std::vector<TriangleSet> sets(pieces_.size());
    for (std::uint32_t t = 0; t < labels.size(); ++t) sets[labels[t]].push_back(t);
    std::vector<Piece> before = std::move(pieces_);
    pieces_.clear();
    for (std::size_t p = 0; p < before.size(); ++p) {
      if (sets[p] == before[p].triangles)
        pieces_.push_back(std::move(before[p]));
      else if (!sets[p].empty())
        add(std::move(sets[p]), before[p].region);
    }
  }

  // Two halves; or, where most of a piece could be projected along its mean normal, that and the scraps that
  // could not.
  std::vector<TriangleSet> partsOf(const TriangleSet& triangles) const {
    if (options_.flattening.parameterisation == Parameterisation::kProjection) {
      const Vec3 axis = meanNormal(surface_, triangles);
      std::vector<std::int32_t> labels;
      double area = 0;
      for (const std::uint32_t t : triangles) {
        labels.push_back(isWithin(surface_, t, axis, options_.flattening.normal_threshold_deg));
        area += surface_.areas[t];
      }
      std::vector<TriangleSet> parts = connectedParts(surface_, triangles, labels);
      const auto holdsMost = [&](const TriangleSet& part) {
        double share = 0;
        for (const std::uint32_t t : part) share += surface_.areas[t] / area;
        return share > 0.5 && isWithin(surface_, part[0], axis, options_.flattening.normal_threshold_deg);
      };
      if (parts.size() > 1 && std::any_of(parts.begin(), parts.end(), holdsMost)) return parts;
    }
    return divided(triangles, 2);
  }

  // Flattens what is not flat, and divides what cannot be, until all are.
  void settle() {
    std::vector<Piece> done, open = std::move(pieces_);
    pieces_.clear();
    while (!open.empty()) {
      std::vector<std::vector<TriangleSet>> parts(open.size());
      tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t i) {
        Piece& piece = open[i];
        if (!piece.flat) piece.flat = flatten(surface_, piece.triangles, options_.flattening);
        if (piece.flat)
          piece.perimeter = perimeterOf(piece.flat->chart);
        else
          parts[i] = partsOf(piece.triangles);
      });
      for (std::size_t i = 0; i < open.size(); ++i) {
        if (open[i].flat) {
          done.push_back(std::move(open[i]));
          continue;
        }
        ++report_.splits;
        for (TriangleSet& part : parts[i]) add(std::move(part), open[i].region);
      }
      open = std::exchange(pieces_, {});
    }
    std::sort(done.begin(), done.end(),
              [](const Piece& a, const Piece& b) { return a.triangles[0] < b.triangles[0]; });
    pieces_ = std::move(done);
  }

  // Those that may become one as far as can be told without laying them flat, longest common border first.
  std::vector<Neighbors> mergeable(const std::set<std::pair<std::uint32_t, std::uint32_t>>& refused) const {
    std::vector<std::size_t> piece_of(surface_.triangleCount());
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      for (const std::uint32_t t : pieces_[p].triangles) piece_of[t] = p;
    std::map<std::pair<std::size_t, std::size_t>, double> lengths;
    for (std::size_t t = 0; t < surface_.triangleCount(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t other = surface_.passable(t, k);
        if (other < 0 || piece_of[other] <= piece_of[t] || regions_[other] != regions_[t]) continue;
        lengths[{piece_of[t], piece_of[other]}] += surface_.edgeLength(t, k);
      }
    std::vector<Neighbors> result;
    for (const auto& [pair, length] : lengths) {
      const Piece &a = pieces_[pair.first], &b = pieces_[pair.second];
      if (refused.contains({a.id, b.id}) || a.flat->chart.area + b.flat->chart.area > options_.largest_share)
        continue;
      result.push_back({pair.first, pair.second, length / std::min(a.perimeter, b.perimeter)});
    }
    std::stable_sort(result.begin(), result.end(),
                     [](const Neighbors& a, const Neighbors& b) { return a.shared > b.shared; });
    return result;
  }

  std::optional<FlatPiece> together(const Piece& a, const Piece& b) const {
    TriangleSet both;
    std::merge(a.triangles.begin(), a.triangles.end(), b.triangles.begin(), b.triangles.end(),
               std::back_inserter(both));
    auto flat = flatten(surface_, both, options_.flattening);
    if (!flat) return flat;
    // A scrap may join a piece that is hollow itself.
    const Piece& larger = a.flat->chart.area < b.flat->chart.area ? b : a;
    if (solidityOf(*flat) < std::min(options_.solidity, solidityOf(*larger.flat))) flat.reset();
    return flat;
  }

  // In rounds: of the mergeable pairs those that do not meet are tried at once.
  void merge() {
    std::set<std::pair<std::uint32_t, std::uint32_t>> refused;
    while (true) {
      std::vector<std::uint8_t> taken(pieces_.size(), 0);
      std::vector<Neighbors> pairs;
      for (const Neighbors& pair : mergeable(refused)) {
        if (taken[pair.a] || taken[pair.b]) continue;
        taken[pair.a] = taken[pair.b] = 1;
        pairs.push_back(pair);
      }
      if (pairs.empty()) return;
      std::vector<std::optional<FlatPiece>> merged(pairs.size());
      tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t i) {
        merged[i] = together(pieces_[pairs[i].a], pieces_[pairs[i].b]);
      });
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        ++report_.merges_tried;
        Piece &a = pieces_[pairs[i].a], &b = pieces_[pairs[i].b];
        if (!merged[i]) {
          refused.insert({a.id, b.id});
          continue;
        }
        ++report_.merges;
        a.triangles = merged[i]->chart.surface_triangles;
        a.id = next_id_++;
        a.perimeter = perimeterOf(merged[i]->chart);
        a.flat = std::move(merged[i]);
        b.triangles.clear();
      }
      std::erase_if(pieces_, [](const Piece& piece) { return piece.triangles.empty(); });
    }
  }

  const Surface& surface_;
  const ChartingOptions& options_;
  ChartingReport& report_;
  std::vector<std::int32_t> regions_;
  std::vector<Piece> pieces_;
  std::uint32_t next_id_ = 0;
};

}  // namespace

std::vector<FlatPiece> makeCharts(const Surface& surface, const ChartingOptions& options,
                                  ChartingReport& report) {
  return Charting(surface, options, report).run();
}

std::vector<FlatPiece> divideCharts(const Surface& surface, std::vector<FlatPiece> pieces,
                                    std::span<const std::size_t> indices, const ChartingOptions& options,
                                    ChartingReport& report) {
  return Charting(surface, options, report).runOn(std::move(pieces), indices);
}

}  // namespace bakelight::atlas
