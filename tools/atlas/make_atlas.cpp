#include "tools/atlas/make_atlas.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "formats/error.h"
#include "tools/atlas/flatten/float_rounding.h"
#include "tools/atlas/flatten/injectivity.h"
#include "tools/atlas/flatten/untangling.h"
#include "tools/atlas/packing/packing.h"
#include "tools/stage/stopwatch.h"

namespace bakelight::atlas {
namespace {

// Of the whole area, see FlatteningOptions.
constexpr double kSmallArea = 1.0 / 400;

ChartingOptions chartingOptions(const AtlasOptions& options) {
  ChartingOptions charting;
  charting.cuts_only = options.cuts_only;
  charting.merging_effort = options.merging_effort;
  charting.flattening.parameterization = options.parameterization;
  charting.flattening.normal_threshold_deg = options.normal_threshold_deg;
  charting.flattening.corners = options.corners;
  charting.flattening.straightness = options.straightness;
  if (options.parameterization != Parameterization::kProjection && !options.cuts_only)
    charting.flattening.max_stretch = options.max_stretch, charting.flattening.small_area = kSmallArea;
  return charting;
}

Packing packed(const std::vector<FlatPiece>& pieces, const AtlasOptions& options, const std::string& file) {
  std::vector<FlatChart> charts;
  charts.reserve(pieces.size());
  for (const FlatPiece& piece : pieces) charts.push_back({piece.plane, piece.chart.triangles});
  return pack(charts, {options.resolution, options.gutter, options.border}, file);
}

// A corner of the atlas's triangles: what decides which vertex it is.
struct AtlasCorner {
  std::uint32_t source;        // vertex of the mesh
  std::uint32_t chart, local;  // vertex of the chart
  std::uint32_t triangle, k;   // of the atlas
};

// The charts where they were packed, in floats.
class PlacedCharts {
 public:
  PlacedCharts(const std::vector<FlatPiece>& pieces, const Packing& packing, int resolution)
      : texcoords_(pieces.size()) {
    std::vector<std::int64_t> nudged(pieces.size(), 0);
    std::vector<std::uint8_t> is_spoiled(pieces.size(), 0);
    tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t c) {
      const Eigen::Rotation2Dd rotation(packing.placements[c].angle_rad);
      texcoords_[c].reserve(pieces[c].plane.size());
      for (const Vec2& p : pieces[c].plane) {
        const Vec2 place =
            (packing.texels_per_unit * (rotation * p) + packing.placements[c].offset) / resolution;
        texcoords_[c].push_back({static_cast<float>(place.x()), static_cast<float>(place.y())});
      }
      nudged[c] = nudgeFlipped(pieces[c].chart.triangles, texcoords_[c]);
      if (isFine(pieces[c].chart, texcoords_[c])) return;
      if (turnBack(pieces[c].chart, packing.texels_per_unit / resolution, texcoords_[c])) return;
      // One triangle cannot be divided: if nothing turns it back it collapses, which is counted.
      if (pieces[c].chart.triangles.size() == 1)
        texcoords_[c][2] = texcoords_[c][1];
      else
        is_spoiled[c] = 1;
    });
    for (std::size_t c = 0; c < pieces.size(); ++c) {
      nudged_ += nudged[c];
      if (is_spoiled[c]) spoiled_.push_back(c);
    }
  }

  const formats::Float2& texcoord(std::uint32_t chart, std::uint32_t vertex) const {
    return texcoords_[chart][vertex];
  }
  std::int64_t nudgedVertices() const { return nudged_; }
  // Charts that rounding has made overlap themselves, ascending.
  const std::vector<std::size_t>& spoiled() const { return spoiled_; }

 private:
  // What rounding has made of narrow notches and small holes.
  static bool turnBack(const Chart& chart, double scale, std::vector<formats::Float2>& texcoords) {
    std::vector<Vec2> plane;
    plane.reserve(texcoords.size());
    for (const formats::Float2& t : texcoords) plane.push_back(Vec2(t[0], t[1]) / scale);
    if (!untangle(chart, plane) || !uncrossBorders(chart, plane)) return false;
    for (std::size_t v = 0; v < plane.size(); ++v)
      texcoords[v] = {static_cast<float>(scale * plane[v].x()), static_cast<float>(scale * plane[v].y())};
    return isFine(chart, texcoords);
  }

  // Triangles too thin for floats may collapse, which covers nothing twice.
  static bool isFine(const Chart& chart, const std::vector<formats::Float2>& texcoords) {
    std::vector<Vec2> plane;
    plane.reserve(texcoords.size());
    for (const formats::Float2& t : texcoords) plane.emplace_back(t[0], t[1]);
    return badTriangles(chart, plane).flipped == 0 &&
           (chart.triangles.size() == 1 || (bordersTurnRight(chart, plane) && !bordersCross(chart, plane)));
  }

  std::vector<std::vector<formats::Float2>> texcoords_;
  std::int64_t nudged_ = 0;
  std::vector<std::size_t> spoiled_;
};

void assemble(const formats::TriangleMesh& mesh, const Surface& surface, const std::vector<FlatPiece>& pieces,
              const PlacedCharts& placed, AtlasResult& result) {
  Atlas& atlas = result.atlas;
  result.source_triangles = surface.source_triangles;
  atlas.chart_count = static_cast<std::uint32_t>(pieces.size());
  atlas.triangle_charts.resize(surface.triangleCount());
  atlas.mesh.triangles.resize(surface.triangleCount());
  atlas.mesh.material_names = mesh.material_names;
  if (!mesh.triangle_materials.empty())
    for (const std::uint32_t t : surface.source_triangles)
      atlas.mesh.triangle_materials.push_back(mesh.triangle_materials[t]);
  std::vector<AtlasCorner> corners;
  corners.reserve(3 * surface.triangleCount());
  for (std::uint32_t c = 0; c < pieces.size(); ++c) {
    const Chart& chart = pieces[c].chart;
    for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
      const std::uint32_t t = chart.surface_triangles[i];
      atlas.triangle_charts[t] = c;
      for (std::uint32_t k = 0; k < 3; ++k)
        corners.push_back({mesh.triangles[surface.source_triangles[t]][k], c, chart.triangles[i][k], t, k});
    }
  }
  const auto key = [](const AtlasCorner& corner) {
    return std::tuple(corner.source, corner.chart, corner.local);
  };
  std::sort(corners.begin(), corners.end(), [&](const AtlasCorner& a, const AtlasCorner& b) {
    return std::tuple_cat(key(a), std::tuple(a.triangle, a.k)) <
           std::tuple_cat(key(b), std::tuple(b.triangle, b.k));
  });
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const AtlasCorner& corner = corners[i];
    if (i == 0 || key(corner) != key(corners[i - 1])) {
      result.source_vertices.push_back(corner.source);
      atlas.mesh.positions.push_back(mesh.positions[corner.source]);
      if (!mesh.normals.empty()) atlas.mesh.normals.push_back(mesh.normals[corner.source]);
      if (!mesh.colors.empty()) atlas.mesh.colors.push_back(mesh.colors[corner.source]);
      atlas.mesh.texcoords.push_back(placed.texcoord(corner.chart, corner.local));
    }
    atlas.mesh.triangles[corner.triangle][corner.k] =
        static_cast<std::uint32_t>(atlas.mesh.positions.size() - 1);
  }
}

void warnAbout(const Surface& surface, AtlasReport& report) {
  report.degenerate_triangles = surface.degenerate_triangles;
  report.non_manifold_edges = surface.non_manifold_edges;
  report.misoriented_edges = surface.misoriented_edges;
  const auto warn = [&](std::int64_t count, const std::string& what) {
    if (count > 0) report.warnings.push_back(std::to_string(count) + " " + what);
  };
  warn(surface.degenerate_triangles, "triangles without area were left out");
  warn(surface.non_manifold_edges, "edges of more than two triangles became chart borders");
  warn(surface.misoriented_edges, "edges whose triangles face opposite ways became chart borders");
}

// Returns the places of chosen corners.
std::vector<std::uint32_t> cut(Surface& surface, const UserCuts& cuts, AtlasReport& report) {
  const MarkedEdges marked = cutMarkedEdges(surface, cuts.marked_edges);
  if (marked.unknown > 0)
    report.warnings.push_back(std::to_string(marked.unknown) + " marked edges are edges of no triangle");
  AppliedCuts applied = applyCuts(surface, cuts.cuts, cuts.cuts_file);
  report.cut_edges = marked.cut + applied.edges;
  return std::move(applied.corner_places);
}

}  // namespace

AtlasResult makeAtlas(const formats::TriangleMesh& mesh, const UserCuts& cuts, const AtlasOptions& options,
                      const std::string& file) {
  AtlasResult result;
  AtlasReport& report = result.report;
  stage::Stopwatch watch(report.seconds);
  Surface surface = surfaceOf(mesh, file);
  warnAbout(surface, report);
  if (!options.cuts_only) report.crease_edges = markCreases(surface, options.crease_angle_deg);
  ChartingOptions charting = chartingOptions(options);
  charting.flattening.corner_places = cut(surface, cuts, report);
  watch.lap("surface");
  std::vector<FlatPiece> pieces = makeCharts(surface, charting, report.charting);
  if (report.charting.is_merging_cut_short)
    report.warnings.push_back("charts were merged as long as the work on it was bounded (" +
                              std::to_string(report.charting.triangles_tried) +
                              " triangles laid flat): fewer charts may be possible");
  watch.lap("charts");
  while (true) {
    const Packing packing = packed(pieces, options, file);
    watch.lap("packing");
    const PlacedCharts placed(pieces, packing, options.resolution);
    if (!placed.spoiled().empty()) {
      pieces = divideCharts(surface, std::move(pieces), placed.spoiled(), charting, report.charting);
      continue;
    }
    report.texels_per_unit = packing.texels_per_unit * surface.scale;
    report.nudged_vertices = placed.nudgedVertices();
    assemble(mesh, surface, pieces, placed, result);
    break;
  }
  report.figures = check(result.atlas, options.resolution, file);
  watch.lap("check");
  if (report.figures.collapsed > 0)
    report.warnings.push_back(std::to_string(report.figures.collapsed) +
                              " triangles are too thin for float texture coordinates");
  return result;
}

AtlasResult ownAtlas(const formats::TriangleMesh& mesh, const AtlasOptions& options,
                     const std::string& file) {
  if (mesh.texcoords.empty())
    throw badInput({file, "", ""}, "the mesh has no texture coordinates of its own", "",
                   "set texcoords to new");
  AtlasResult result;
  stage::Stopwatch watch(result.report.seconds);
  result.atlas = atlasOf(mesh);
  for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v) result.source_vertices.push_back(v);
  for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) result.source_triangles.push_back(t);
  result.report.figures = check(result.atlas, options.resolution, file);
  watch.lap("check");
  const AtlasFigures& figures = result.report.figures;
  if (figures.defects() > 0 || figures.smallest_gutter < options.gutter)
    throw badInput({file, "", ""},
                   "its own texture coordinates are no valid atlas: " + std::to_string(figures.flipped) +
                       " triangles flipped, " + std::to_string(figures.collapsed) + " collapsed, " +
                       std::to_string(figures.overlapping_texels) + " texels covered twice, " +
                       std::to_string(figures.crossing_edges) + " borders crossing, " +
                       std::to_string(figures.outside) + " vertices outside the square, smallest gutter " +
                       std::to_string(figures.smallest_gutter) + " texels",
                   "none of these, and gutters of " + std::to_string(options.gutter) + " texels",
                   "set texcoords to new");
  if (options.border > 0 && figures.smallest_gutter < options.gutter + 2 * options.border)
    result.report.warnings.push_back("its own gutters leave less than " + std::to_string(options.border) +
                                     " texels for borders between some charts");
  return result;
}

}  // namespace bakelight::atlas
