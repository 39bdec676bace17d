#include "tools/atlas/charts/charting.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "tools/atlas/charts/proxy.h"
#include "tools/atlas/charts/segmentation.h"

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
  std::vector<Vec2> directions;  // of the triangles, until they are among the guides
  double perimeter = 0;
  bool is_merged = false;  // with what it may be merged with
  bool is_finished = false;
};

// Two pieces with a common border.
struct Contact {
  std::uint32_t a, b;  // ids of pieces, a < b
  double length;
  bool is_refused = false;
};

// Contacts of the same two pieces become one.
void unite(std::vector<Contact>& contacts) {
  std::stable_sort(contacts.begin(), contacts.end(), [](const Contact& left, const Contact& right) {
    return std::tie(left.a, left.b) < std::tie(right.a, right.b);
  });
  std::size_t count = 0;
  for (const Contact& contact : contacts) {
    if (count > 0 && contacts[count - 1].a == contact.a && contacts[count - 1].b == contact.b)
      contacts[count - 1].length += contact.length;
    else
      contacts[count++] = contact;
  }
  contacts.resize(count);
}

// Two pieces that may become one.
struct Candidate {
  std::size_t a, b;     // pieces
  std::size_t contact;  // which
  double shared;        // length of the common border ÷ the smaller perimeter
};

// In parallel, those of many triangles first, so that none is left alone at the end.
template <class Work>
void forEachLargestFirst(const std::vector<Piece>& pieces, const Work& work) {
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return pieces[a].triangles.size() > pieces[b].triangles.size();
  });
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(
      std::size_t{0}, order.size(), [&](std::size_t) { work(order[next++]); }, tbb::simple_partitioner());
}

constexpr int kMostParts = 8;
// A proxy has at most this share of the triangles, or there is none; and never less than a 16th.
constexpr double kLeastReduction = 1.5;
constexpr std::size_t kLargestReduction = 16;
// Of the stretch above 1 that charts may have, on the proxy.
constexpr double kShareOfProxy = 0.9;
// Of a neighbour's area: what is smaller joins it untried.
constexpr double kScrap = 1.0 / 200;
// Of the effort of merging: its greater part is done on the proxy, where it costs less.
constexpr double kShareOfMerging = 1.0 / 20;
// Of all triangles, that the first merges beside a proxy's charts may take, and by what that grows when none
// are left.
constexpr std::int64_t kSmallestMerges = 256;
constexpr std::int64_t kGrowthOfMerges = 4;

class Charting {
 public:
  Charting(const Surface& surface, const ChartingOptions& options, ChartingReport& report)
      : surface_(surface), options_(options), report_(report) {
    guides_.directions.resize(surface.triangleCount());
    guides_.planes.assign(surface.triangleCount(), -1);
  }

  std::vector<FlatPiece> run() {
    makePieces();
    return flatPieces();
  }

  // Only which triangles belong together: a label for each, and how they lie.
  std::vector<std::int32_t> labels() {
    makePieces();
    return pieceLabels();
  }
  const Guides& guides() const { return guides_; }

  std::vector<FlatPiece> runOn(std::vector<FlatPiece> pieces, std::span<const std::size_t> to_divide) {
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      const TriangleSet& triangles = pieces[p].chart.surface_triangles;
      if (std::binary_search(to_divide.begin(), to_divide.end(), p) && triangles.size() > 1) {
        ++report_.splits;
        for (TriangleSet& part : divided(triangles, 2)) add(std::move(part), 0);
      } else {
        add(triangles, 0);
        pieces_.back().flat = std::move(pieces[p]);
        pieces_.back().is_finished = true;
      }
    }
    settle();
    return flatPieces();
  }

 private:
  void makePieces() {
    findRegions();
    if (!options_.cuts_only) {
      if (!isWorthProxy() || !takePiecesOfProxy()) divideRegions();
      straighten();
      if (report_.proxy_triangles > 0) joinScraps();
      settle();
      merge();
      // Straight borders would bring triangles with them that cannot be projected; and those of a proxy's
      // charts are straight already.
      if (options_.flattening.parameterization != Parameterization::kProjection &&
          report_.proxy_triangles == 0)
        straighten();
    }
    settle();
  }

  std::vector<std::int32_t> pieceLabels() const {
    std::vector<std::int32_t> labels(surface_.triangleCount());
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      for (const std::uint32_t t : pieces_[p].triangles) labels[t] = static_cast<std::int32_t>(p);
    return labels;
  }

  // Whether a triangle can be projected depends on its own normal, which a proxy does not have.
  bool isWorthProxy() const {
    return options_.flattening.parameterization != Parameterization::kProjection &&
           static_cast<double>(surface_.triangleCount()) >
               kLeastReduction * static_cast<double>(options_.proxy_triangles);
  }

  // Where pieces begin and end is found on fewer triangles; they are laid flat as they are, and what does not
  // lie flat for its details is divided and merged anew. Returns false if a proxy could leave out too little.
  bool takePiecesOfProxy() {
    const Proxy proxy =
        proxyOf(surface_, std::max(options_.proxy_triangles, surface_.triangleCount() / kLargestReduction));
    if (kLeastReduction * static_cast<double>(proxy.surface.triangleCount()) >
        static_cast<double>(surface_.triangleCount()))
      return false;
    report_.proxy_triangles = static_cast<std::int64_t>(proxy.surface.triangleCount());
    ChartingOptions options = options_;
    options.proxy_triangles = surface_.triangleCount();
    options.flattening.corner_places.clear();
    // Details take their share of the stretch.
    options.flattening.max_stretch = 1 + kShareOfProxy * (options.flattening.max_stretch - 1);
    ChartingReport report;
    Charting charting(proxy.surface, options, report);
    const std::vector<std::int32_t> proxy_labels = charting.labels(),
                                    nearest = nearestOfProxy(surface_, regions_, proxy);
    std::vector<std::int32_t> labels(nearest.size(), -1);
    guides_.planes = labels;
    next_plane_ = charting.next_plane_;
    tbb::parallel_for(std::size_t{0}, nearest.size(), [&](std::size_t t) {
      if (nearest[t] < 0) return;
      labels[t] = proxy_labels[nearest[t]];
      guides_.planes[t] = charting.guides().planes[nearest[t]];
      guides_.directions[t] =
          directionBeside(surface_, static_cast<std::uint32_t>(t), proxy.surface,
                          static_cast<std::uint32_t>(nearest[t]), charting.guides().directions[nearest[t]]);
    });
    report_.first_pieces = report.first_pieces;
    report_.splits = report.splits;
    report_.merges = report.merges;
    report_.merges_tried = report.merges_tried;
    report_.triangles_tried = report.triangles_tried;
    report_.is_merging_cut_short = report.is_merging_cut_short;
    // What the proxy has nothing of stays whole.
    const std::int32_t count = 1 + *std::max_element(labels.begin(), labels.end());
    for (std::size_t t = 0; t < labels.size(); ++t)
      if (labels[t] < 0) labels[t] = count + regions_[t];
    pieces_.clear();
    for (TriangleSet& set : connectedParts(surface_, labels)) {
      const std::int32_t region = regions_[set[0]];
      add(std::move(set), region);
      pieces_.back().is_merged = true;
    }
    return true;
  }

  std::vector<FlatPiece> flatPieces() {
    forEachLargestFirst(pieces_, [&](std::size_t p) {
      if (!pieces_[p].is_finished) finish(*pieces_[p].flat, options_.flattening);
    });
    std::vector<FlatPiece> result;
    result.reserve(pieces_.size());
    for (Piece& piece : pieces_) result.push_back(std::move(*piece.flat));
    return result;
  }

  // How a piece lies, for what will be made of its triangles.
  void remember(Piece& piece) {
    if (piece.directions.empty()) return;
    guides_.set(piece.triangles, piece.directions, next_plane_++);
    piece.directions.clear();
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
      Flattening whole = flatten(surface_, pieces_[p].triangles, options_.flattening);
      if (whole.piece && solidityOf(*whole.piece) >= options_.solidity)
        pieces_[p].flat = std::move(whole.piece), pieces_[p].directions = std::move(whole.directions);
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
    std::vector<std::int32_t> labels = pieceLabels();
    straightenBorders(surface_, regions_, labels);
    std::vector<Piece> before = std::move(pieces_);
    pieces_.clear();
    for (TriangleSet& set : connectedParts(surface_, labels)) {
      Piece& piece = before[labels[set[0]]];
      if (set == piece.triangles) {
        pieces_.push_back(std::move(piece));
      } else {
        add(std::move(set), piece.region);
        pieces_.back().is_merged = piece.is_merged;
      }
    }
  }

  // What labels from a proxy and straightening leave on the wrong side of a border, to the larger neighbour
  // with the longest common border: merging would lay that flat once more for each.
  void joinScraps() {
    std::vector<std::size_t> piece_of(next_id_), into(pieces_.size());
    std::vector<double> areas(pieces_.size(), 0), lengths(pieces_.size(), 0);
    std::iota(into.begin(), into.end(), std::size_t{0});
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      piece_of[pieces_[p].id] = p;
      for (const std::uint32_t t : pieces_[p].triangles) areas[p] += surface_.areas[t];
    }
    for (const Contact& contact : contacts()) {
      std::size_t small = piece_of[contact.a], large = piece_of[contact.b];
      if (areas[large] < areas[small]) std::swap(small, large);
      if (!(areas[small] < kScrap * areas[large]) || contact.length <= lengths[small]) continue;
      lengths[small] = contact.length;
      into[small] = large;
    }
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      std::size_t whole = p;
      while (into[whole] != whole) whole = into[whole];  // ever larger ones
      if (whole == p) continue;
      TriangleSet& all = pieces_[whole].triangles;
      TriangleSet& scrap = pieces_[p].triangles;
      all.insert(all.end(), scrap.begin(), scrap.end());
      scrap.clear();
      pieces_[whole].flat.reset();
    }
    std::erase_if(pieces_, [](const Piece& piece) { return piece.triangles.empty(); });
    for (Piece& piece : pieces_) std::sort(piece.triangles.begin(), piece.triangles.end());
  }

  // Halves, or more parts where more are likely to be needed; or, where most of a piece could be projected
  // along its mean normal, that and the scraps that could not.
  std::vector<TriangleSet> partsOf(const TriangleSet& triangles, double excess) const {
    if (options_.flattening.parameterization == Parameterization::kProjection) {
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
    // Stretch above 1 grows with the square of the area, as long as that is curved alike.
    return divided(triangles,
                   std::clamp(static_cast<int>(std::sqrt(std::min(excess, 100.0))), 2, kMostParts));
  }

  // Flattens what is not flat, and divides what cannot be, until all are.
  void settle() {
    std::vector<Piece> done, open = std::move(pieces_);
    pieces_.clear();
    while (!open.empty()) {
      std::vector<std::vector<TriangleSet>> parts(open.size());
      forEachLargestFirst(open, [&](std::size_t i) {
        Piece& piece = open[i];
        double excess = 0;
        if (!piece.flat) {
          Flattening flattening = flatten(surface_, piece.triangles, options_.flattening, guides_);
          piece.flat = std::move(flattening.piece);
          piece.directions = std::move(flattening.directions);
          excess = flattening.excess;
        }
        if (piece.flat)
          piece.perimeter = perimeterOf(piece.flat->chart);
        else
          parts[i] = partsOf(piece.triangles, excess);
      });
      for (std::size_t i = 0; i < open.size(); ++i) {
        remember(open[i]);
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

  std::vector<Contact> contacts() const {
    std::vector<std::uint32_t> id_of(surface_.triangleCount());
    std::vector<std::uint8_t> is_merged(next_id_, 0);
    for (const Piece& piece : pieces_) {
      is_merged[piece.id] = piece.is_merged;
      for (const std::uint32_t t : piece.triangles) id_of[t] = piece.id;
    }
    std::vector<Contact> result;
    for (std::size_t t = 0; t < surface_.triangleCount(); ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t other = surface_.passable(t, k);
        if (other >= 0 && id_of[other] > id_of[t] && regions_[other] == regions_[t])
          result.push_back({id_of[t], id_of[other], surface_.edgeLength(t, k)});
      }
    unite(result);
    for (Contact& contact : result) contact.is_refused = is_merged[contact.a] && is_merged[contact.b];
    return result;
  }

  // Those that may become one as far as can be told without laying them flat, longest common border first.
  std::vector<Candidate> candidates(const std::vector<Contact>& contacts) const {
    std::vector<std::size_t> piece_of(next_id_);
    for (std::size_t p = 0; p < pieces_.size(); ++p) piece_of[pieces_[p].id] = p;
    std::vector<Candidate> result;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const std::size_t a = piece_of[contacts[c].a], b = piece_of[contacts[c].b];
      if (contacts[c].is_refused ||
          pieces_[a].flat->chart.area + pieces_[b].flat->chart.area > options_.largest_share)
        continue;
      result.push_back({a, b, c, contacts[c].length / std::min(pieces_[a].perimeter, pieces_[b].perimeter)});
    }
    std::stable_sort(result.begin(), result.end(),
                     [](const Candidate& a, const Candidate& b) { return a.shared > b.shared; });
    return result;
  }

  Flattening together(const Piece& a, const Piece& b) const {
    TriangleSet both;
    std::merge(a.triangles.begin(), a.triangles.end(), b.triangles.begin(), b.triangles.end(),
               std::back_inserter(both));
    Flattening flat = flatten(surface_, both, options_.flattening, guides_);
    if (!flat.piece) return flat;
    // A scrap may join a piece that is hollow itself.
    const Piece& larger = a.flat->chart.area < b.flat->chart.area ? b : a;
    if (solidityOf(*flat.piece) < std::min(options_.solidity, solidityOf(*larger.flat))) flat.piece.reset();
    return flat;
  }

  // In rounds: of the candidates those that do not meet are tried at once. On large surfaces small ones come
  // first: else each scrap beside a large piece would lay that flat once more.
  void merge() {
    std::vector<Contact> all = contacts();
    const bool has_proxy = report_.proxy_triangles > 0;
    const double effort = options_.merging_effort * (has_proxy ? kShareOfMerging : 1);
    const auto most_work = report_.triangles_tried +
                           static_cast<std::int64_t>(effort * static_cast<double>(surface_.triangleCount()));
    const auto whole = static_cast<std::int64_t>(surface_.triangleCount());
    std::int64_t work = report_.triangles_tried;
    std::int64_t largest = has_proxy ? std::max<std::int64_t>(1, whole / kSmallestMerges) : whole;
    while (true) {
      std::vector<std::uint8_t> taken(pieces_.size(), 0);
      std::vector<Candidate> pairs;
      for (const Candidate& pair : candidates(all)) {
        if (taken[pair.a] || taken[pair.b]) continue;
        const auto triangles =
            static_cast<std::int64_t>(pieces_[pair.a].triangles.size() + pieces_[pair.b].triangles.size());
        if (triangles > largest) continue;
        if (work + triangles > most_work) {
          report_.is_merging_cut_short = true;
          continue;
        }
        work += triangles;
        taken[pair.a] = taken[pair.b] = 1;
        pairs.push_back(pair);
      }
      report_.triangles_tried = work;
      if (pairs.empty()) {
        if (largest >= whole) return;
        largest *= kGrowthOfMerges;
        continue;
      }
      std::vector<Flattening> merged(pairs.size());
      tbb::parallel_for(
          std::size_t{0}, pairs.size(),
          [&](std::size_t i) { merged[i] = together(pieces_[pairs[i].a], pieces_[pairs[i].b]); },
          tbb::simple_partitioner());
      std::vector<std::uint32_t> new_ids(next_id_);
      std::iota(new_ids.begin(), new_ids.end(), 0u);
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        ++report_.merges_tried;
        if (!merged[i].piece) {
          all[pairs[i].contact].is_refused = true;
          continue;
        }
        ++report_.merges;
        Piece &a = pieces_[pairs[i].a], &b = pieces_[pairs[i].b];
        new_ids[a.id] = new_ids[b.id] = next_id_;
        a.id = next_id_++;
        a.triangles = merged[i].piece->chart.surface_triangles;
        a.perimeter = perimeterOf(merged[i].piece->chart);
        a.flat = std::move(merged[i].piece);
        a.directions = std::move(merged[i].directions);
        remember(a);
        a.is_merged = false;
        b.triangles.clear();
      }
      std::erase_if(pieces_, [](const Piece& piece) { return piece.triangles.empty(); });
      rename(all, new_ids);
    }
  }

  // What was refused may be tried again with a piece that has grown.
  static void rename(std::vector<Contact>& contacts, const std::vector<std::uint32_t>& new_ids) {
    for (Contact& contact : contacts) {
      const auto [a, b] = std::minmax(new_ids[contact.a], new_ids[contact.b]);
      contact.is_refused = contact.is_refused && a == contact.a && b == contact.b;
      contact.a = a, contact.b = b;
    }
    std::erase_if(contacts, [](const Contact& contact) { return contact.a == contact.b; });
    unite(contacts);
  }

  const Surface& surface_;
  const ChartingOptions& options_;
  ChartingReport& report_;
  std::vector<std::int32_t> regions_;
  std::vector<Piece> pieces_;
  std::uint32_t next_id_ = 0;
  Guides guides_;
  std::int32_t next_plane_ = 0;
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
