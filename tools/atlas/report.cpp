#include "tools/atlas/report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "formats/mesh_ply.h"
#include "tools/atlas/check_report.h"

namespace bakelight::atlas {

formats::Json toJson(const AtlasReport& report) {
  formats::Json json;
  for (const auto& [name, value] : figuresOf(report.figures)) json[name] = value;
  json["texels_per_unit"] = report.texels_per_unit;
  json["regions"] = report.charting.regions;
  json["first_pieces"] = report.charting.first_pieces;
  json["splits"] = report.charting.splits;
  json["merges"] = report.charting.merges;
  json["merges_tried"] = report.charting.merges_tried;
  json["proxy_triangles"] = report.charting.proxy_triangles;
  json["merge_triangles_tried"] = report.charting.triangles_tried;
  json["crease_edges"] = report.crease_edges;
  json["cut_edges"] = report.cut_edges;
  json["degenerate_triangles"] = report.degenerate_triangles;
  json["non_manifold_edges"] = report.non_manifold_edges;
  json["misoriented_edges"] = report.misoriented_edges;
  json["nudged_vertices"] = report.nudged_vertices;
  for (const auto& [step, seconds] : report.seconds) json["seconds_" + step] = seconds;
  return json;
}

formats::TensorFile chartTables(const AtlasResult& result, const AtlasOptions& options) {
  using formats::ElementType;
  formats::TensorFile file;
  const auto put = [&](const std::string& name, const std::vector<std::uint32_t>& values) {
    file.tensors[name] = formats::Tensor::from<std::uint32_t>(ElementType::kUint32, {values.size()}, values);
  };
  put("triangle_charts", result.atlas.triangle_charts);
  put("source_triangles", result.source_triangles);
  put("source_vertices", result.source_vertices);
  file.metadata = {{"charts", std::to_string(result.atlas.chart_count)},
                   {"resolution", std::to_string(options.resolution)},
                   {"gutter", std::to_string(options.gutter)},
                   {"border", std::to_string(options.border)},
                   {"texels_per_unit", fmt::format("{:.17g}", result.report.texels_per_unit)},
                   {"geometry_hash", formats::geometryHash(result.atlas.mesh)}};
  return file;
}

}  // namespace bakelight::atlas
