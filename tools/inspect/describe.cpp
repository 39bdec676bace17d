#include "tools/inspect/describe.h"

#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/stage_record.h"
#include "tools/inspect/atlas_figures.h"
#include "tools/inspect/describe_parts.h"
#include "tools/inspect/image_figures.h"
#include "tools/inspect/mesh_figures.h"
#include "tools/inspect/tensor_figures.h"

namespace bakelight::inspect {

using formats::Json;

namespace {

constexpr double kUnitTolerance = 1e-4;  // of a normal's length, well above a float's rounding

Section sizeSection(const MeshFigures& figures) {
  Section size{"size", {}, {}, {}};
  size.figures = {{"vertices", figures.vertices, ""},
                  {"triangles", figures.triangles, ""},
                  {"minimum", listOf(figures.minimum), ""},
                  {"maximum", listOf(figures.maximum), ""},
                  {"diagonal", figures.diagonal, ""},
                  {"area", figures.area, ""},
                  {"volume", figures.closed ? Json(figures.volume) : Json(), ""}};
  return size;
}

Section shapeSection(const MeshFigures& figures) {
  return {"triangle_shape",
          {{"shortest_edge", figures.edge_length.minimum(), ""},
           {"mean_edge", figures.edge_length.mean(), ""},
           {"longest_edge", figures.edge_length.maximum(), ""},
           {"smallest_angle_deg", figures.smallest_angle_deg.minimum(), "deg"},
           {"mean_smallest_angle_deg", figures.smallest_angle_deg.mean(), "deg"},
           {"degenerate_triangles", figures.degenerate_triangles, ""}},
          {},
          {}};
}

Section atlasSection(const AtlasFigures& figures) {
  return {"texture_coordinates",
          {{"charts", figures.charts, ""},
           {"unit_square_share", figures.unit_square_share, ""},
           {"l2_stretch", std::isfinite(figures.l2_stretch) ? Json(figures.l2_stretch) : Json(), ""},
           {"mirrored_charts", figures.mirrored_charts, ""},
           {"flipped_triangles", figures.flipped_triangles, ""},
           {"collapsed_triangles", figures.collapsed_triangles, ""},
           {"triangles_outside", figures.triangles_outside, ""}},
          {},
          {}};
}

Section topologySection(const MeshFigures& figures) {
  return {"topology",
          {{"closed", figures.closed, ""},
           {"components", figures.components, ""},
           {"euler_characteristic", figures.euler_characteristic, ""},
           {"edges", figures.edges, ""},
           {"borders", figures.borders, ""},
           {"border_edges", figures.border_edges, ""},
           {"non_manifold_edges", figures.non_manifold_edges, ""},
           {"misoriented_edges", figures.misoriented_edges, ""},
           {"distinct_positions", figures.distinct_positions, ""},
           {"isolated_vertices", figures.isolated_vertices, ""}},
          {},
          {}};
}

Section attributesSection(const MeshFigures& figures, const std::string& hash) {
  const bool normals = figures.has_normals;
  return {"attributes",
          {{"normals", normals, ""},
           {"unit_normals", normals ? Json(figures.normal_length_error <= kUnitTolerance) : Json(), ""},
           {"normal_length_error", normals ? Json(figures.normal_length_error) : Json(), ""},
           {"texcoords", figures.has_texcoords, ""},
           {"colors", figures.has_colors, ""},
           {"geometry_hash", hash, ""}},
          {},
          {}};
}

// Names come from files of any program: what is no UTF-8 becomes U+FFFD, control characters question marks.
std::string printable(const std::string& name) {
  std::string text =
      Json::parse(Json(name).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, '?');
  return text;
}

Section materialsSection(const formats::TriangleMesh& mesh, const MeshFigures& figures) {
  Section section{"materials", {}, {"index", "name", "triangles", "area"}, {}};
  for (std::size_t m = 0; m < figures.materials.size(); ++m)
    section.rows.push_back(
        {m, printable(mesh.material_names[m]), figures.materials[m].triangles, figures.materials[m].area});
  return section;
}

std::string shapeText(const std::vector<std::uint64_t>& shape) {
  std::string text;
  for (const std::uint64_t extent : shape) text += (text.empty() ? "" : " × ") + std::to_string(extent);
  return text.empty() ? "scalar" : text;
}

// Nested objects become dotted names.
void flatten(const Json& object, const std::string& prefix, std::vector<Figure>& figures) {
  for (const auto& [name, value] : object.items()) {
    if (value.is_object())
      flatten(value, prefix + name + ".", figures);
    else
      figures.push_back({prefix + name, value, ""});
  }
}

Section listSection(const std::string& name, const std::string& column,
                    const std::vector<std::string>& texts) {
  Section section{name, {}, {column}, {}};
  for (const std::string& text : texts) section.rows.push_back({text});
  return section;
}

Json memberOr(const Json& object, const char* name, const Json& otherwise) {
  return object.is_object() && object.contains(name) ? object[name] : otherwise;
}

// If there is a tensor of that name that holds transfer: vertices × channels × order².
void addBands(const formats::TensorFile& file, const char* tensor_name, const std::string& section,
              std::vector<Section>& sections) {
  const auto entry = file.tensors.find(tensor_name);
  if (entry == file.tensors.end()) return;
  const formats::Tensor& tensor = entry->second;
  if (tensor.type != formats::ElementType::kFloat32 || tensor.shape.empty() || tensor.elementCount() == 0)
    return;
  if (const int order = orderOfColumns(tensor.shape.back()))
    sections.push_back(bandSection(section, tensor.as<float>(), order));
}

std::vector<Section> describeAssetRecord(const Json& json) {
  std::vector<Section> sections = {{"asset",
                                    {{"name", memberOr(json, "asset", Json()), ""},
                                     {"recipe", memberOr(json, "recipe", Json()), ""},
                                     {"stages", json["stages"].size(), ""}},
                                    {},
                                    {}}};
  Section stages{
      "stages", {}, {"stage", "tool", "status", "wall_s", "cpu_s", "peak_memory_bytes", "reason"}, {}};
  Section warnings{"warnings", {}, {"stage", "warning"}, {}};
  for (const auto& [name, stage] : json["stages"].items()) {
    std::vector<Json> row = {name};
    for (std::size_t c = 1; c < stages.columns.size(); ++c)
      row.push_back(memberOr(stage, stages.columns[c].c_str(), Json()));
    stages.rows.push_back(std::move(row));
    for (const Json& warning : memberOr(stage, "warnings", Json::array()))
      warnings.rows.push_back({name, warning});
  }
  sections.push_back(std::move(stages));
  if (!warnings.rows.empty()) sections.push_back(std::move(warnings));
  for (const auto& [name, stage] : json["stages"].items()) {
    Section stats{"stats_of_" + name, {}, {}, {}};
    flatten(memberOr(stage, "stats", Json::object()), "", stats.figures);
    if (!stats.figures.empty()) sections.push_back(std::move(stats));
  }
  return sections;
}

}  // namespace

std::vector<Section> describeMesh(const formats::TriangleMesh& mesh, const std::vector<std::string>& notes) {
  const MeshFigures figures = measureMesh(mesh);
  std::vector<Section> sections = {sizeSection(figures), shapeSection(figures), topologySection(figures),
                                   attributesSection(figures, formats::geometryHash(mesh))};
  if (!mesh.texcoords.empty()) sections.push_back(atlasSection(measureAtlas(mesh)));
  if (!figures.materials.empty()) sections.push_back(materialsSection(mesh, figures));
  if (!notes.empty()) sections.push_back(listSection("notes", "note", notes));
  return sections;
}

std::vector<Section> describeImage(const formats::Image& image, const std::string& file) {
  std::vector<Section> sections = {
      {"size", {{"width_px", image.width, "px"}, {"height_px", image.height, "px"}}, {}, {}}};
  Section channels{"channels", {}, {"channel", "minimum", "mean", "maximum", "nan", "infinite"}, {}};
  const std::vector<Moments> moments = measureChannels(image);
  for (std::size_t c = 0; c < moments.size(); ++c)
    channels.rows.push_back({image.channel_names[c], moments[c].minimum(), moments[c].mean(),
                             moments[c].maximum(), moments[c].nanCount(), moments[c].infiniteCount()});
  sections.push_back(std::move(channels));

  if (const auto probe = measureProbe(image, file)) {
    const transport::Vec3& towards = probe->brightest_direction;
    const double degrees = 180 / std::numbers::pi;
    sections.push_back({"as_lat_long_probe",
                        {{"mean_radiance", probe->mean_radiance, ""},
                         {"brightest_radiance", probe->brightest_radiance, ""},
                         {"brightest_direction", {towards.x(), towards.y(), towards.z()}, ""},
                         {"brightest_yaw_deg", std::atan2(towards.x(), towards.z()) * degrees, "deg"},
                         {"brightest_elevation_deg", std::asin(towards.y()) * degrees, "deg"},
                         {"dynamic_range_stops", probe->dynamic_range_stops, "stops"}},
                        {},
                        {}});
  }
  return sections;
}

std::vector<Section> describeTensors(const formats::TensorFile& file) {
  Section table{
      "tensors", {}, {"tensor", "type", "shape", "minimum", "mean", "maximum", "rms", "nan", "infinite"}, {}};
  for (const auto& [name, tensor] : file.tensors) {
    const Moments moments = measureTensor(tensor);
    table.rows.push_back({name, formats::safetensorsName(tensor.type), shapeText(tensor.shape),
                          moments.minimum(), moments.mean(), moments.maximum(), moments.rootMeanSquare(),
                          moments.nanCount(), moments.infiniteCount()});
  }
  std::vector<Section> sections = {std::move(table)};
  if (!file.metadata.empty()) {
    Section metadata{"metadata", {}, {}, {}};
    for (const auto& [key, value] : file.metadata) metadata.figures.push_back({key, value, ""});
    sections.push_back(std::move(metadata));
  }
  addBands(file, "transfer", "energy_per_sh_band", sections);
  addBands(file, "near_transfer", "near_energy_per_sh_band", sections);
  return sections;
}

std::vector<Section> describeMaterials(const formats::Materials& materials) {
  const Json json = formats::toJson(materials);
  const auto section = [](const std::string& title, const Json& material) {
    Section described{title, {}, {}, {}};
    flatten(material, "", described.figures);
    return described;
  };
  std::vector<Section> sections = {section("material", json["material"])};
  const Json named = memberOr(json, "materials", Json::object());
  for (const auto& [name, material] : named.items())
    sections.push_back(section("material_of_" + printable(name), material));
  return sections;
}

std::vector<Section> describeRecord(const Json& json, const std::string& file) {
  if (memberOr(json, "stages", Json()).is_object() && json.contains("asset"))
    return describeAssetRecord(json);
  if (!memberOr(json, "tool", Json()).is_string() || !json.contains("wall_s"))
    throw badInput({file, "", ""}, "this JSON is no record of a run",
                   "a stage's stats.json or an asset's record.json",
                   "recipes and asset.json are text: open them in an editor");
  const formats::StageRecord record = formats::stageRecordFromJson(json, file);
  std::vector<Section> sections = {{"run",
                                    {{"tool", record.tool, ""},
                                     {"wall_s", record.wall_s, "s"},
                                     {"cpu_s", record.cpu_s, "s"},
                                     {"peak_memory_bytes", record.peak_memory_bytes, "bytes"}},
                                    {},
                                    {}}};
  Section stats{"stats", {}, {}, {}};
  flatten(record.stats, "", stats.figures);
  if (!stats.figures.empty()) sections.push_back(std::move(stats));
  if (!record.warnings.empty()) sections.push_back(listSection("warnings", "warning", record.warnings));
  return sections;
}

}  // namespace bakelight::inspect
