#include "tools/mesomesh/retile/retile.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "formats/error.h"
#include "formats/materials.h"
#include "surface/losses.h"
#include "surface/metrics.h"
#include "surface/working_mesh.h"
#include "tools/mesomesh/retile/figures.h"
#include "tools/mesomesh/retile/original_surface.h"
#include "tools/mesomesh/retile/parted_mesh.h"
#include "tools/mesomesh/retile/remesher.h"
#include "tools/mesomesh/retile/sliding.h"
#include "tools/mesomesh/retile/subdivision.h"
#include "tools/stage/stopwatch.h"

namespace bakelight::mesomesh {
namespace {

using surface::WorkingMesh;

constexpr int kMostSubdivisions = 3;
// The coarse mesh has at least this many vertices for each of the original's, so that it resolves what the
// original does, and at least so many at all.
constexpr double kCoarseShare = 1.5;
constexpr std::int64_t kLeastCoarse = 4000;
constexpr int kLeastRounds = 6, kMostRounds = 24, kPolishRounds = 4, kEvenRounds = 2, kStuckRounds = 3;
// Where the rounds stop; the rest of the tolerance is for what the estimate of copies leaves out.
constexpr double kGoodCount = 0.02, kNearCount = 0.1;
// A share of triangles this large that face away from the original says that the coarse mesh was too coarse.
constexpr double kFoldedShare = 1e-4;
// Creases shorter than this many edges of the result are noise.
constexpr double kLeastCreaseEdges = 5;
// Edges of fewer steps between neighbouring floats have no direction.
constexpr double kLeastFloatSteps = 8;
// Length of the working box's diagonal, to within two.
constexpr double kWorkingDiagonal = 1024;

void checkInput(const formats::TriangleMesh& mesh, const std::string& file) {
  if (mesh.triangles.empty())
    throw badInput({file, "", ""}, "the mesh has no triangle", "at least one triangle");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t i : mesh.triangles[t])
      if (i >= mesh.positions.size())
        throw badInput({file, "face " + std::to_string(t), ""},
                       "vertex index " + std::to_string(i) + " is out of range",
                       "an index below " + std::to_string(mesh.positions.size()));
  formats::requireMaterials(mesh);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    for (const float x : mesh.positions[v])
      if (!std::isfinite(x))
        throw badInput({file, "vertex " + std::to_string(v), ""}, "a coordinate is not finite", "a number",
                       "repair the mesh in its modelling program");
}

// Powers of two, so that what lies on the original keeps its last bit but for the shift.
struct WorkingFrame {
  Vec3 center;
  double scale;

  explicit WorkingFrame(const Eigen::AlignedBox3d& box) : center(box.center()), scale(1) {
    const double diagonal = box.diagonal().norm();
    if (diagonal > 0) scale = std::exp2(std::floor(std::log2(kWorkingDiagonal / diagonal)));
  }
};

double sheetArea(const WorkingMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.isSheet(t)) sum += mesh.areaVector(t).norm() / 2;
  return sum;
}

// Of a tiling of equilateral triangles: √3/2·L² of area a vertex.
double edgeLength(double area, double vertices) {
  return std::sqrt(2 * area / (std::numbers::sqrt3 * vertices));
}

std::string scientific(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

void requireResolution(const formats::TriangleMesh& mesh, double edge, const std::string& file) {
  float farthest = 0;
  for (const formats::Float3& p : mesh.positions)
    for (const float x : p) farthest = std::max(farthest, std::abs(x));
  const double step =
      static_cast<double>(std::nextafter(farthest, std::numeric_limits<float>::infinity())) - farthest;
  if (edge >= kLeastFloatSteps * step) return;
  throw badInput({file, "", ""},
                 "so many vertices would be " + scientific(edge) + " apart, where the coordinates (up to " +
                     scientific(farthest) + ") tell no two apart that are closer than " + scientific(step),
                 "edges of at least " + scientific(kLeastFloatSteps * step),
                 "ask for fewer vertices, or move the mesh to the origin");
}

// What is asked for, by how many times the number of vertices on one side of sheets.
struct Target {
  double vertices = 0;
  double front_share = 1;

  double ratio(const CornerMesh& mesh, int subdivisions) const {
    return static_cast<double>(partedCount(mesh, subdivisions)) / front_share / vertices;
  }
};

SlidingMesh coarseMesh(const OriginalSurface& original, const Target& target, double area, int subdivisions) {
  SlidingMesh mesh = original.mesh();
  const double count = target.vertices * target.front_share / std::pow(4.0, subdivisions);
  const auto most = static_cast<std::size_t>(8 * count) + 2 * mesh.mesh.positions.size() + 1000;
  double length = edgeLength(area, count), last_ratio = 0;
  int stuck = 0;
  for (int round = 0; round < kMostRounds; ++round) {
    remeshOnce(mesh, original, length, most);
    const double ratio = target.ratio(mesh.mesh, subdivisions);
    if (round + 1 >= kLeastRounds && std::abs(ratio - 1) <= kGoodCount) break;
    // Features and components need as many as there are.
    stuck = ratio > 1 && std::abs(ratio - last_ratio) < 1e-3 * ratio ? stuck + 1 : 0;
    if (stuck == kStuckRounds && ratio > 1 + kCountTolerance) break;
    last_ratio = ratio;
    if (mesh.mesh.positions.size() > 3 * most / 4) mesh = compacted(mesh);
    // Evening out keeps edges between the bounds that splits and collapses have, so near the end the number
    // follows slowly: a longer step there than √ratio, which is right before.
    const double exponent = std::abs(ratio - 1) < kNearCount ? 0.8 : 0.5;
    length *= std::clamp(std::pow(ratio, exponent), 0.5, 2.0);
  }
  polish(mesh, original, kPolishRounds);
  return compacted(mesh);
}

SlidingMesh retiled(const OriginalSurface& original, const Target& target, double area, RetileReport& report,
                    stage::Stopwatch& watch) {
  const auto original_vertices = static_cast<double>(original.mesh().mesh.positions.size());
  const double least = std::max(kCoarseShare * original_vertices, static_cast<double>(kLeastCoarse));
  int subdivisions = 0;
  while (subdivisions < kMostSubdivisions &&
         target.vertices * target.front_share / std::pow(4.0, subdivisions + 1) >= least)
    ++subdivisions;
  for (;; --subdivisions) {
    SlidingMesh mesh = coarseMesh(original, target, area, subdivisions);
    report.coarse_vertices = static_cast<std::int64_t>(mesh.mesh.positions.size());
    report.subdivisions = subdivisions;
    watch.lap("coarse");
    for (int level = 0; level < subdivisions; ++level) {
      const std::size_t old_count = mesh.mesh.positions.size();
      mesh = subdivided(mesh);
      drop(mesh, original, old_count);
      evenOut(mesh, original, kEvenRounds);
    }
    report.folded_triangles = static_cast<std::int64_t>(foldedTriangles(mesh, original));
    watch.lap("subdivide");
    const double allowed = kFoldedShare * static_cast<double>(mesh.mesh.triangles.size());
    if (static_cast<double>(report.folded_triangles) <= allowed || subdivisions == 0) return mesh;
  }
}

void requireCount(const RetileReport& report, std::int64_t asked, const std::string& file) {
  const double ratio = static_cast<double>(report.vertices) / static_cast<double>(asked);
  if (std::abs(ratio - 1) <= kCountTolerance) return;
  const std::string why = ratio > 1 ? "its " + std::to_string(report.components) + " components, " +
                                          std::to_string(report.corners) +
                                          " corners and the lines between them need as many"
                                    : "its thin triangles have too little area for more";
  throw badInput({file, "", ""},
                 std::to_string(asked) + " vertices cannot be had: the mesh came to " +
                     std::to_string(report.vertices) + ", as " + why,
                 "a number that the mesh can be retiled to within " +
                     std::to_string(static_cast<int>(100 * kCountTolerance)) + "%",
                 ratio > 1
                     ? "ask for " + std::to_string(report.vertices) + " or more, or raise crease_angle_deg"
                     : "ask for fewer, or repair the mesh");
}

}  // namespace

RetiledMesh retile(const formats::TriangleMesh& input, const RetileOptions& options,
                   const std::string& file) {
  checkInput(input, file);
  surface::checkScale(input, file);
  RetiledMesh result;
  RetileReport& report = result.report;
  stage::Stopwatch watch(report.seconds);
  WorkingMesh mesh = surface::workingMesh(input);
  const surface::Extent extent = surface::extentOf(mesh);
  const WorkingFrame frame(extent.working());
  for (Vec3& p : mesh.positions) p = (p - frame.center) * frame.scale;
  report.repairs = surface::repair(mesh, 0);
  if (mesh.triangles.empty())
    throw badInput({file, "", ""}, "no triangle of the mesh has an area",
                   "at least one triangle with an area");
  report.warnings = surface::lossWarnings(input, extent, 0, report.repairs);
  if (report.repairs.one_sided_cuts > 0)
    report.warnings.push_back(std::to_string(report.repairs.one_sided_cuts) +
                              " edges were cut, as no orientation agrees across them (a Möbius strip): the "
                              "tiling and its texture have a seam there");
  if (report.repairs.non_manifold_edges > 0)
    report.warnings.push_back(std::to_string(report.repairs.non_manifold_edges) +
                              " edges of more than two triangles were cut or paired");
  const surface::Topology topology = surface::topology(mesh);
  report.components = topology.components;
  report.border_edges = topology.boundary_edges;
  const double area = surface::area(mesh);
  const Target target{static_cast<double>(options.vertices), area / (area + sheetArea(mesh))};
  const double fine_edge = edgeLength(area, target.vertices * target.front_share);
  requireResolution(input, fine_edge / frame.scale, file);
  watch.lap("repair");

  const OriginalSurface original(mesh, options.crease_angle_deg, kLeastCreaseEdges * fine_edge);
  report.crease_edges = original.features().crease_edges;
  report.material_edges = original.features().material_edges;
  report.corners = original.features().corners;
  watch.lap("prepare");
  SlidingMesh sliding = retiled(original, target, area, report, watch);
  measureTiling(sliding, report);
  PartedMesh tiling = parted(sliding, original, mesh.sheets);
  report.vertices = static_cast<std::int64_t>(tiling.positions.size());
  report.triangles = static_cast<std::int64_t>(tiling.triangles.size());
  report.crease_copies = tiling.crease_copies;
  requireCount(report, options.vertices, file);
  watch.lap("normals");
  measureDeviation(sliding, original, surface::boundingBoxDiagonal(mesh), report);
  report.edge_length /= frame.scale;
  if (report.folded_triangles > 0)
    report.warnings.push_back(std::to_string(report.folded_triangles) +
                              " triangles face away from the surface they lie on");
  watch.lap("measure");

  formats::TriangleMesh& out = result.mesh;
  out.positions.resize(tiling.positions.size()), out.normals.resize(tiling.positions.size());
  tbb::parallel_for(std::size_t{0}, tiling.positions.size(), [&](std::size_t v) {
    out.positions[v] = transport::float3(tiling.positions[v] / frame.scale + frame.center);
    out.normals[v] = transport::float3(tiling.normals[v]);
  });
  out.triangles = std::move(tiling.triangles);
  result.materials = std::move(tiling.vertex_materials);
  if (!input.triangle_materials.empty()) {
    out.triangle_materials = std::move(tiling.triangle_materials);
    out.material_names = input.material_names;
  }
  watch.lap("finish");
  return result;
}

}  // namespace bakelight::mesomesh
