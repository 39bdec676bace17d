// The atlas stage: from a mesh to charts, laid flat and packed.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tools/atlas/atlas.h"
#include "tools/atlas/charts/charting.h"
#include "tools/atlas/charts/cuts.h"
#include "tools/atlas/check.h"

namespace bakelight::atlas {

// Largest L² stretch of a chart, by preset. Convex polygons cost stretch at their corners whatever the chart.
inline constexpr double kFewCharts = 1.04, kLowDistortion = 1.005;
inline constexpr double kFewPolygons = 1.25, kLowDistortionPolygons = 1.1;

struct AtlasOptions {
  Parameterization parameterization = Parameterization::kFree;
  bool cuts_only = false;           // charts are what the cuts leave
  double max_stretch = kFewCharts;  // L² stretch of each chart, ≥ 1, that has 1/400 of the area; projections
                                    // have whatever they have
  double straightness = 5;  // free borders: how far the teeth of borders are drawn flat, see free_boundary.h
  double crease_angle_deg = 80;      // edges sharper than this separate charts where they close up
  double normal_threshold_deg = 30;  // projection
  double merging_effort = 40;        // bound of the work on merging charts, see charting.h
  int corners = 8;                   // convex: of polygons without chosen ones
  int resolution = 1024;             // texels, of the square's side
  int gutter = 2;                    // texels
  int border = 0;                    // texels around each chart that are its own, too
};

// What a person chose.
struct UserCuts {
  Cuts cuts;
  std::string cuts_file;                                   // that errors name
  std::vector<std::array<std::uint32_t, 2>> marked_edges;  // by vertices of the mesh
};

struct AtlasReport {
  ChartingReport charting;
  AtlasFigures figures;        // of the finished atlas, judged anew
  double texels_per_unit = 0;  // of the asset's unit of length
  std::int64_t degenerate_triangles = 0, crease_edges = 0, cut_edges = 0, non_manifold_edges = 0,
               misoriented_edges = 0;
  std::int64_t nudged_vertices = 0;       // moved by a rounding, so that no triangle is flipped
  std::map<std::string, double> seconds;  // by step
  std::vector<std::string> warnings;
};

struct AtlasResult {
  Atlas atlas;
  std::vector<std::uint32_t> source_vertices;   // of the atlas's vertices: which of the mesh's
  std::vector<std::uint32_t> source_triangles;  // of the atlas's triangles
  AtlasReport report;
};

// Triangles keep their order, those without area are left out. Vertices are ordered by the mesh's, then by
// chart; one whose triangles lie in several charts has a copy in each. Normals and colours are copied. No
// triangle is flipped and no two overlap (check.h judges the floats that are written); touched texels and
// gutters as packing.h has them. Deterministic, the same for any number of threads. Throws Error(kBadInput)
// as surfaceOf() and pack() do.
AtlasResult makeAtlas(const formats::TriangleMesh& mesh, const UserCuts& cuts, const AtlasOptions& options,
                      const std::string& file);

// Takes the mesh's own texture coordinates: the very same mesh with its charts. Throws Error(kBadInput)
// naming `file`, with the figures, if they are no valid atlas at the resolution and gutter of `options`.
AtlasResult ownAtlas(const formats::TriangleMesh& mesh, const AtlasOptions& options, const std::string& file);

}  // namespace bakelight::atlas
