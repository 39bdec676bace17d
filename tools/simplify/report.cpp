#include "tools/simplify/report.h"

#include <nlohmann/json.hpp>

namespace bakelight::simplify {
namespace {

using Json = nlohmann::json;

Json toJson(const RepairCounts& counts) {
  return {{"welded_vertices", counts.welded_vertices},
          {"repeated_index_triangles", counts.repeated_index_triangles},
          {"duplicate_triangles", counts.duplicate_triangles},
          {"reversed_triangles", counts.reversed_triangles},
          {"sheet_triangles", counts.sheet_triangles},
          {"zero_area_triangles", counts.zero_area_triangles},
          {"kept_needles", counts.kept_needles},
          {"non_manifold_edges", counts.non_manifold_edges},
          {"non_manifold_vertices", counts.non_manifold_vertices},
          {"added_vertices", counts.added_vertices},
          {"reoriented_triangles", counts.reoriented_triangles},
          {"one_sided_cuts", counts.one_sided_cuts},
          {"inside_out_components", counts.inside_out_components},
          {"isolated_vertices", counts.isolated_vertices}};
}

// Of the mesh before or after.
Json state(std::int64_t vertices, std::int64_t triangles, const Topology& topology,
           const AngleQuality& angles, double area, double volume) {
  return {{"vertices", vertices},
          {"triangles", triangles},
          {"components", topology.components},
          {"boundary_edges", topology.boundary_edges},
          {"closed", topology.closed()},
          {"euler_characteristic", topology.euler_characteristic},
          {"mean_min_angle_deg", angles.mean_min_angle_deg},
          {"worst_min_angle_deg", angles.worst_min_angle_deg},
          {"area", area},
          {"volume", volume}};
}

}  // namespace

Json toJson(const SimplifyReport& r) {
  return {{"repairs", toJson(r.repairs)},
          {"input", state(r.vertices_in, r.triangles_in, r.topology_in, r.angles_in, r.area_in, r.volume_in)},
          {"output",
           state(r.vertices_out, r.triangles_out, r.topology_out, r.angles_out, r.area_out, r.volume_out)},
          {"small_parts", r.small_parts.parts},
          {"small_part_triangles", r.small_parts.triangles},
          {"crease_edges", r.crease_edges},
          {"corners", r.corners},
          {"materials", r.materials},
          {"material_edges", r.material_edges},
          {"material_vertices", r.material_vertices},
          {"edge_splits", r.splits},
          {"collapses", r.collapses},
          {"constraints", r.constraints},
          {"edge_flips", r.flips},
          {"split_vertices", r.split_vertices},
          {"seam_vertices", r.seam_vertices},
          {"hausdorff_over_diagonal", r.deviation.hausdorff},
          {"mean_distance_over_diagonal", r.deviation.mean},
          {"seconds", r.seconds},
          {"left_out", r.left_out}};
}

}  // namespace bakelight::simplify
