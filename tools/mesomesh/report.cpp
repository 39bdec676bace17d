#include "tools/mesomesh/report.h"

#include <nlohmann/json.hpp>

#include "transport/vector_types.h"

namespace bakelight::mesomesh {

using formats::Json;

Json toJson(const RetileReport& r, const DirectionField& field) {
  const surface::RepairCounts& repairs = r.repairs;
  Json seconds = Json::object();
  for (const auto& [step, spent] : r.seconds) seconds["retile_" + step] = spent;
  for (const auto& [step, spent] : field.seconds) seconds["field_" + step] = spent;
  return {{"vertices", r.vertices},
          {"triangles", r.triangles},
          {"crease_copies", r.crease_copies},
          {"components", r.components},
          {"coarse_vertices", r.coarse_vertices},
          {"subdivisions", r.subdivisions},
          {"crease_edges", r.crease_edges},
          {"material_edges", r.material_edges},
          {"border_edges", r.border_edges},
          {"corners", r.corners},
          {"edge_length", r.edge_length},
          {"mean_quality", r.mean_quality},
          {"least_quality", r.least_quality},
          {"six_neighbors_share", r.six_neighbors},
          {"folded_triangles", r.folded_triangles},
          {"largest_deviation_over_diagonal", r.largest_deviation},
          {"mean_deviation_over_diagonal", r.mean_deviation},
          {"repairs",
           {{"welded_vertices", repairs.welded_vertices},
            {"repeated_index_triangles", repairs.repeated_index_triangles},
            {"duplicate_triangles", repairs.duplicate_triangles},
            {"reversed_triangles", repairs.reversed_triangles},
            {"sheet_triangles", repairs.sheet_triangles},
            {"zero_area_triangles", repairs.zero_area_triangles},
            {"non_manifold_edges", repairs.non_manifold_edges},
            {"non_manifold_vertices", repairs.non_manifold_vertices},
            {"reoriented_triangles", repairs.reoriented_triangles},
            {"one_sided_cuts", repairs.one_sided_cuts},
            {"inside_out_components", repairs.inside_out_components}}},
          {"singularities", field.singularities.size()},
          {"index_sum", field.index_sum},
          {"seconds", seconds}};
}

Json singularityTable(const formats::TriangleMesh& mesh, const DirectionField& field, int symmetry) {
  Json list = Json::array();
  for (const Singularity& s : field.singularities) {
    const auto& [a, b, c] = mesh.triangles[s.triangle];
    const formats::Float3 middle =
        transport::float3((transport::vec3(mesh.positions[a]) + transport::vec3(mesh.positions[b]) +
                           transport::vec3(mesh.positions[c])) /
                          3);
    list.push_back({{"point", middle}, {"index", static_cast<double>(s.index) / symmetry}});
  }
  return {{"symmetry", symmetry}, {"singularities", list}};
}

}  // namespace bakelight::mesomesh
