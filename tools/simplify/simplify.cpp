#include "tools/simplify/simplify.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numbers>

#include "formats/error.h"
#include "formats/materials.h"
#include "surface/corner_mesh.h"
#include "surface/features.h"
#include "surface/losses.h"
#include "tools/simplify/decimate.h"
#include "tools/simplify/double_sided.h"
#include "tools/simplify/normals.h"
#include "tools/simplify/refine.h"
#include "tools/simplify/relax.h"
#include "tools/simplify/small_parts.h"
#include "tools/simplify/surface_words.h"
#include "tools/simplify/texcoords.h"
#include "tools/stage/stopwatch.h"
#include "transport/surface_query.h"

namespace bakelight::simplify {
namespace {

// Length of the bounding box's diagonal while working, or of the bulk's.
constexpr double kWorkingDiagonal = 1000;
// Creases shorter than this many sides of the triangles asked for are taken for noise.
constexpr double kMinCreaseSides = 5;
// Edges longer than this many of those sides are split before decimation.
constexpr double kMaxEdgeSides = 2;
// Refined so far that decimation has some to choose from.
constexpr double kRefinedEdgeSides = 1;
constexpr std::int64_t kRefinedSplits = 4;
// One in so many triangles is left for the places that fit worst after the first half of the relaxation.
constexpr std::size_t kReserveDivisor = 100;
constexpr std::size_t kDeviationSamples = 100'000;

void checkInput(const formats::TriangleMesh& mesh, const std::string& file) {
  if (mesh.triangles.empty())
    throw badInput({file, "", ""}, "the mesh has no triangle", "at least one triangle");
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t i : mesh.triangles[t]) {
      if (i < mesh.positions.size()) continue;
      throw badInput({file, "face " + std::to_string(t), ""},
                     "vertex index " + std::to_string(i) + " is out of range",
                     "an index below " + std::to_string(mesh.positions.size()));
    }
  }
  formats::requireMaterials(mesh);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (const float x : mesh.positions[v]) {
      if (!std::isfinite(x)) {
        throw badInput({file, "vertex " + std::to_string(v), ""}, "a coordinate is not finite");
      }
    }
  }
}

// The similarity between the asset's coordinates and those of this stage.
struct WorkingFrame {
  Vec3 center = Vec3::Zero();
  double scale = 1;  // working unit ÷ asset unit

  explicit WorkingFrame(const Extent& extent) {
    const Eigen::AlignedBox3d& box = extent.working();
    center = box.center();
    if (box.diagonal().norm() > 0) scale = kWorkingDiagonal / box.diagonal().norm();
  }
  void apply(WorkingMesh& mesh) const {
    for (Vec3& p : mesh.positions) p = (p - center) * scale;
  }
  void undo(WorkingMesh& mesh) const {
    for (Vec3& p : mesh.positions) p = p / scale + center;
  }
};

double equilateralSide(double triangle_area) {
  return std::sqrt(4 * triangle_area / std::numbers::sqrt3);
}

WorkingMesh reduce(const SurfaceQuery& original, const SimplifyOptions& options, SimplifyReport& report,
                   stage::Stopwatch& watch) {
  CornerMesh mesh(original.mesh());
  const double side = equilateralSide(area(original.mesh()) / options.triangles);
  if (options.refine)
    report.splits =
        splitLongEdges(mesh, kRefinedEdgeSides * side, kRefinedSplits * std::int64_t{options.triangles});
  else if (options.relax_rounds > 0)
    report.splits = splitLongEdges(mesh, kMaxEdgeSides * side, options.triangles);
  const FeatureCounts features = markFeatures(mesh, options.crease_angle_deg, kMinCreaseSides * side);
  report.crease_edges = features.crease_edges;
  report.material_edges = features.material_edges;
  report.corners = features.corners;
  const auto target = static_cast<std::size_t>(options.triangles);
  const std::size_t reserve = options.relax_rounds > 0 ? target / kReserveDivisor / 2 * 2 : 0;
  const DecimationResult decimation = decimate(mesh, target - reserve);
  report.collapses = static_cast<std::int64_t>(decimation.collapses);
  report.constraints = name(decimation.level);
  if (!decimation.reached) {
    report.warnings.push_back(
        "the target of " + std::to_string(options.triangles) +
        " triangles cannot be reached: a closed component keeps at least 4, an open one 1" +
        (features.material_edges > 0 ? ", and borders between materials stay" : ""));
  }
  mesh.compact();
  watch.lap("decimate");
  if (options.relax_rounds > 0) {
    report.flips =
        relax(mesh, original, options.relax_rounds, target - std::min(target, mesh.triangles.size())).flips;
  } else {
    report.left_out.push_back("relaxation: relax_rounds is 0");
  }
  watch.lap("relax");
  return {std::move(mesh.positions), std::move(mesh.triangles), std::move(mesh.materials)};
}

// Backs of sheets come on top of the triangles that are left here.
SimplifyOptions withoutBacks(SimplifyOptions options, const WorkingMesh& mesh) {
  std::size_t backs = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) backs += mesh.isSheet(t);
  const auto fronts = static_cast<double>(mesh.triangles.size());
  options.triangles =
      std::max(4, static_cast<int>(options.triangles * (fronts / (fronts + static_cast<double>(backs)))));
  return options;
}

// The back sides of sheets follow, as addBacksTo() appends them.
WorkingMesh withBacks(WorkingMesh mesh) {
  const std::size_t fronts = mesh.triangles.size();
  for (std::size_t t = 0; t < fronts; ++t) {
    const auto [a, b, c] = mesh.triangles[t];
    if (mesh.isSheet(t)) mesh.triangles.push_back({a, c, b});
  }
  return mesh;
}

void addSheetBacks(formats::TriangleMesh& mesh, const std::vector<WorkingMesh::Sheet>& sheets) {
  if (sheets.empty()) return;
  std::vector<std::uint8_t> has_back;
  std::vector<std::uint32_t> backs;
  for (std::uint32_t& material : mesh.triangle_materials) {
    has_back.push_back(material >= kFirstSheet);
    if (material < kFirstSheet) continue;
    const WorkingMesh::Sheet& sheet = sheets[material - kFirstSheet];
    backs.push_back(sheet.back);
    material = sheet.front;
  }
  addBacksTo(mesh, has_back);
  std::copy(backs.begin(), backs.end(),
            mesh.triangle_materials.begin() + static_cast<std::ptrdiff_t>(has_back.size()));
}

}  // namespace

SimplifyResult simplify(const formats::TriangleMesh& input, const SimplifyOptions& options,
                        const std::string& file) {
  checkInput(input, file);
  checkScale(input, file);
  SimplifyResult result;
  SimplifyReport& report = result.report;
  stage::Stopwatch watch(report.seconds);
  report.vertices_in = static_cast<std::int64_t>(input.vertexCount());
  report.triangles_in = static_cast<std::int64_t>(input.triangleCount());

  WorkingMesh mesh = workingMesh(input);
  const Extent extent = extentOf(mesh);
  const WorkingFrame frame(extent);
  frame.apply(mesh);
  const double weld_tolerance = options.weld_tolerance * kWorkingDiagonal;
  const WorkingMesh unrepaired = input.texcoords.empty() ? WorkingMesh{} : mesh;
  report.repairs = repair(mesh, weld_tolerance);
  if (mesh.triangles.empty()) {
    throw badInput({file, "", ""}, "no triangle of the mesh has an area",
                   "at least one triangle with an area");
  }
  report.warnings = lossWarnings(input, extent, weld_tolerance / frame.scale, report.repairs);
  if (options.least_part > 0) {
    report.small_parts = removeSmallParts(mesh, options.least_part);
    if (report.small_parts.parts > 0)
      report.warnings.push_back(std::to_string(report.small_parts.parts) + " parts of " +
                                std::to_string(report.small_parts.triangles) + " triangles, " +
                                std::to_string(100 * report.small_parts.area_share) +
                                " % of the area, are smaller than least_part, and were left out");
  }
  report.topology_in = topology(mesh);
  const std::vector<WorkingMesh::Sheet> sheets = mesh.sheets;
  const SimplifyOptions one_sided = withoutBacks(options, mesh);
  watch.lap("repair");

  std::vector<CornerTexcoords> texcoords;
  const double unit = 1 / frame.scale;
  report.angles_in = angleQuality(mesh);
  report.area_in = area(mesh) * unit * unit;
  report.volume_in = volume(mesh) * unit * unit * unit;
  const auto wanted = static_cast<std::size_t>(one_sided.triangles);
  if (mesh.triangles.size() > wanted || (one_sided.refine && mesh.triangles.size() < wanted)) {
    const SurfaceQuery original(std::move(mesh));
    mesh = reduce(original, one_sided, report, watch);
    if (!input.texcoords.empty())
      report.left_out.push_back("texture coordinates: decimation moves their seams");
    report.topology_out = topology(mesh);
    report.angles_out = angleQuality(mesh);
    report.area_out = area(mesh) * unit * unit;
    report.volume_out = volume(mesh) * unit * unit * unit;
    report.deviation = deviation(original, SurfaceQuery(mesh), kDeviationSamples);
    report.deviation.hausdorff /= kWorkingDiagonal;
    report.deviation.mean /= kWorkingDiagonal;
  } else {
    report.left_out.push_back("decimation: " + std::to_string(mesh.triangles.size()) +
                              " triangles are no more than the " + std::to_string(options.triangles) +
                              " asked for");
    if (!input.texcoords.empty())
      texcoords = texcoordsThroughRepair(input, unrepaired, weld_tolerance, withBacks(mesh));
    if (!input.texcoords.empty() && texcoords.empty()) {
      report.left_out.push_back("texture coordinates: the repair changed triangles");
      report.warnings.push_back("texture coordinates were left out: the repair changed triangles");
    }
    report.topology_out = report.topology_in;
    report.angles_out = report.angles_in;
    report.area_out = report.area_in;
    report.volume_out = report.volume_in;
  }
  watch.lap("measure");

  frame.undo(mesh);
  const double side = equilateralSide(area(mesh) / static_cast<double>(mesh.triangles.size()));
  ShadedMesh shaded = withNormals(mesh, options.crease_angle_deg, kMinCreaseSides * side);
  report.split_vertices = shaded.split_vertices;
  report.material_vertices = shaded.material_vertices;
  result.mesh = std::move(shaded.mesh);
  addSheetBacks(result.mesh, sheets);
  if (input.triangle_materials.empty()) result.mesh.triangle_materials.clear();
  result.mesh.material_names = input.material_names;
  report.materials = static_cast<std::int64_t>(formats::usedMaterials(result.mesh));
  if (!texcoords.empty()) report.seam_vertices = setTexcoords(result.mesh, texcoords);
  report.vertices_out = static_cast<std::int64_t>(result.mesh.vertexCount());
  report.triangles_out = static_cast<std::int64_t>(result.mesh.triangleCount());
  for (std::string& warning : roundingWarnings(result.mesh)) report.warnings.push_back(std::move(warning));
  watch.lap("normals");
  return result;
}

}  // namespace bakelight::simplify
