#include "formats/material.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/json_reader.h"
#include "formats/materials.h"
#include "formats/tensors.h"
#include "formats/words.h"

namespace bakelight::formats {
namespace {

namespace fs = std::filesystem;

constexpr JsonReader::Range kShare = {0, 1}, kExponent = {0, 100000},
                            kWidth = {std::numeric_limits<double>::min(), 1e15}, kDepth = {1e-6, 100};
constexpr const char* kColorOrTexture = "three numbers from 0 to 1, or the file name of a picture";

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

fs::path fileNamed(const JsonReader& name, const FileResolver& files) {
  return files(name.text(), name.place());
}

Reflection readLambert(const JsonReader&, const FileResolver&) {
  return Lambert{};
}

Reflection readPhong(const JsonReader& object, const FileResolver&) {
  PhongReflection phong;
  object.read("specular_color", phong.specular_color, kShare);
  object.read("exponent", phong.exponent, kExponent);
  return phong;
}

Reflection readGgx(const JsonReader& object, const FileResolver&) {
  GgxReflection ggx;
  object.read("specular_color", ggx.specular_color, kShare);
  object.read("roughness", ggx.roughness, kShare);
  object.read("fresnel", ggx.fresnel);
  object.read("multiple_scattering", ggx.multiple_scattering);
  return ggx;
}

Reflection readTableReflection(const JsonReader& object, const FileResolver& files) {
  return TableReflection{fileNamed(object.at("file", "a file of the brdf tool"), files), {}};
}

// In the order of Reflection's alternatives.
constexpr Word<Reflection (*)(const JsonReader&, const FileResolver&)> kModels[] = {
    {"none", readLambert}, {"phong", readPhong}, {"ggx", readGgx}, {"table", readTableReflection}};

Reflection reflectionFrom(const JsonReader& object, const FileResolver& files) {
  Reflection reflection = object.choice("model", kModels)(object, files);
  object.refuseOthers();
  return reflection;
}

PatchHeight heightFrom(const JsonReader& object, const FileResolver& files) {
  PatchHeight height;
  height.file = fileNamed(object.at("file", "a picture of heights"), files);
  object.read("depth", height.depth, kDepth);
  object.refuseOthers();
  return height;
}

constexpr Word<PatchMesh::Up> kUps[] = {{"z", PatchMesh::Up::kZ}, {"y", PatchMesh::Up::kY}};

PatchMesh patchMeshFrom(const JsonReader& object, const FileResolver& files) {
  PatchMesh mesh;
  mesh.file = fileNamed(object.at("file", "a mesh"), files);
  object.read("up", mesh.up, kUps);
  if (const auto period = object.find("period")) {
    const std::vector<double> sides = period->numbers(2);
    for (std::size_t i = 0; i < sides.size(); ++i) period->at(i).number(kWidth);
    mesh.period = {sides[0], sides[1]};
  }
  object.refuseOthers();
  return mesh;
}

Patch patchFrom(const JsonReader& object, const FileResolver& files) {
  Patch patch;
  if (const auto file = object.find("file")) patch.file = fileNamed(*file, files);
  if (object.has("width")) patch.width = object.number("width", kWidth);
  object.read("periodic", patch.periodic);
  if (const auto height = object.find("height")) patch.height = heightFrom(*height, files);
  if (const auto geometry = object.find("geometry")) patch.geometry = patchMeshFrom(*geometry, files);
  if (patch.height && patch.geometry)
    throw object.at("geometry")
        .error("a patch has one surface, and this one has a \"height\", too",
               "either \"height\" or \"geometry\"");
  if (const auto rtt = object.find("rtt")) {
    patch.rtt = fileNamed(rtt->at("file", "a file of rtt or btf"), files);
    rtt->refuseOthers();
    if (patch.height || patch.geometry)
      throw rtt->error("a patch that is rendered already has no surface to render, and this one has",
                       "either \"rtt\", or \"height\" or \"geometry\"");
  }
  if (const auto btf = object.find("btf")) {
    patch.btf = fileNamed(btf->at("file", "a .btf file, or a zip of pictures"), files);
    btf->refuseOthers();
    if (patch.height || patch.geometry || !patch.rtt.empty())
      throw btf->error("a patch that is measured has no surface to render, and this one has, or an \"rtt\"",
                       "one of \"btf\", \"rtt\", \"height\" and \"geometry\"");
  }
  if (const auto texture = object.find("texture")) {
    patch.texture = fileNamed(texture->at("file", "a picture"), files);
    texture->refuseOthers();
  }
  if (const auto albedo = object.find("albedo")) patch.albedo = albedo->float3(kShare);
  object.refuseOthers();
  if (!patch.hasSurface() && patch.rtt.empty() && patch.btf.empty())
    throw object.error(
        "it has neither a picture nor a surface",
        "\"file\": a picture, \"height\": a picture of heights, \"geometry\": a mesh, \"btf\", or \"rtt\"");
  return patch;
}

Material materialFrom(const JsonReader& object, const FileResolver& files) {
  Material material;
  object.read("name", material.name);
  if (const auto albedo = object.find("albedo")) {
    if (albedo->value().is_string())
      material.texture = fileNamed(*albedo, files);
    else if (albedo->value().is_array())
      material.albedo = albedo->float3(kShare);
    else
      throw albedo->error(albedo->value().dump() + " is no albedo", kColorOrTexture);
  }
  if (const auto reflection = object.find("reflection"))
    material.reflection = reflectionFrom(*reflection, files);
  if (const auto patch = object.find("patch")) material.patch = patchFrom(*patch, files);
  if (const auto medium = object.find("medium")) material.medium = mediumFrom(*medium);
  object.refuseOthers();
  return material;
}

void readTable(Material& material) {
  if (auto* table = std::get_if<TableReflection>(&material.reflection))
    table->table = readBrdfTable(table->file);
}

Json numbersOf(const Float3& values) {
  Json numbers = Json::array();
  for (const float value : values) numbers.push_back(shortestDouble(value));
  return numbers;
}

Json toJson(const Reflection& reflection) {
  Json json = {{"model", nameOf(reflection)}};
  std::visit(Overloaded{[](const Lambert&) {},
                        [&](const PhongReflection& phong) {
                          json["specular_color"] = numbersOf(phong.specular_color);
                          json["exponent"] = phong.exponent;
                        },
                        [&](const GgxReflection& ggx) {
                          json["specular_color"] = numbersOf(ggx.specular_color);
                          json["roughness"] = ggx.roughness;
                          json["fresnel"] = ggx.fresnel;
                          json["multiple_scattering"] = ggx.multiple_scattering;
                        },
                        [&](const TableReflection& table) { json["file"] = table.file.string(); }},
             reflection);
  return json;
}

Json toJson(const Patch& patch) {
  Json json = {{"periodic", patch.periodic}};
  if (!patch.file.empty()) json["file"] = patch.file.string();
  if (!patch.rtt.empty()) json["rtt"] = {{"file", patch.rtt.string()}};
  if (!patch.btf.empty()) json["btf"] = {{"file", patch.btf.string()}};
  if (patch.width) json["width"] = *patch.width;
  if (patch.height) json["height"] = {{"file", patch.height->file.string()}, {"depth", patch.height->depth}};
  if (patch.geometry) {
    json["geometry"] = {{"file", patch.geometry->file.string()}, {"up", wordFor(kUps, patch.geometry->up)}};
    if (patch.geometry->period) json["geometry"]["period"] = *patch.geometry->period;
  }
  if (!patch.texture.empty()) json["texture"] = {{"file", patch.texture.string()}};
  if (patch.albedo) json["albedo"] = numbersOf(*patch.albedo);
  return json;
}

bool isOfAlbedo(const std::optional<Medium>& medium) {
  return medium && medium->reflectance == ReflectanceSource::kAlbedo;
}

Json toJson(const Material& material, const std::vector<std::string>& parts) {
  const auto wanted = [&](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  Json json = Json::object();
  if (wanted("name") && !material.name.empty()) json["name"] = material.name;
  const bool albedo_wanted = wanted("albedo") || (wanted("medium") && isOfAlbedo(material.medium));
  if (albedo_wanted && material.albedo) json["albedo"] = numbersOf(*material.albedo);
  if (albedo_wanted && !material.texture.empty()) json["albedo"] = material.texture.string();
  if (wanted("reflection") && !std::holds_alternative<Lambert>(material.reflection))
    json["reflection"] = toJson(material.reflection);
  if (wanted("patch") && material.patch) json["patch"] = toJson(*material.patch);
  if (wanted("medium") && material.medium) json["medium"] = toJson(*material.medium);
  return json;
}

Float3 albedoWithoutColors(const Material& material) {
  return material.medium ? Float3{1, 1, 1} : kDefaultAlbedo;
}

// Finds out what each vertex's albedo is, and that it has one only.
class VertexAlbedo {
 public:
  VertexAlbedo(const TriangleMesh& mesh, const std::string& mesh_file)
      : mesh_(mesh),
        file_(mesh_file),
        values_(mesh.vertexCount(), kDefaultAlbedo),
        material_of_(mesh.vertexCount(), kNone) {}

  void give(std::uint32_t vertex, const std::string& name, std::uint32_t number, const Material& material) {
    const Float3 albedo = material.albedo        ? *material.albedo
                          : mesh_.colors.empty() ? albedoWithoutColors(material)
                                                 : mesh_.colors[vertex];
    if (material_of_[vertex] != kNone && material_of_[vertex] != number && values_[vertex] != albedo)
      throw badInput({file_, "vertex " + std::to_string(vertex), ""},
                     "it belongs to faces of \"" + name + "\" and of \"" +
                         mesh_.material_names[material_of_[vertex]] + "\", whose albedos differ",
                     "a vertex of its own for each material",
                     "run the mesh through simplify, which makes them");
    values_[vertex] = albedo;
    material_of_[vertex] = number;
  }

  std::vector<Float3> take() { return std::move(values_); }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  const TriangleMesh& mesh_;
  const std::string& file_;
  std::vector<Float3> values_;
  std::vector<std::uint32_t> material_of_;
};

void requireNames(const TriangleMesh& mesh, const Materials& materials, const std::string& file) {
  for (const auto& [name, material] : materials.by_name) {
    const auto& known = mesh.material_names;
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string list;
    for (const std::string& each : known) list += (list.empty() ? "\"" : ", \"") + each + "\"";
    const std::string nearest = nearestName(name, known);
    throw badInput({file, "", childPointer("/materials", name)},
                   "no face of the mesh has a material of the name \"" + name + "\"",
                   list.empty() ? "a mesh that gives its faces materials" : "one of: " + list,
                   nearest.empty() ? "" : "write \"" + nearest + "\"");
  }
}

void requireColors(const TriangleMesh& mesh, const Materials& materials, const std::string& file) {
  if (!materials.base.texture.empty() && mesh.colors.empty())
    throw badInput({file, "", "/albedo"},
                   "the mesh has no colours of the texture " + materials.base.texture.string(),
                   "a mesh with colours at its vertices", "run it through simplify with that texture");
  const auto require = [&](const Material& material, const std::string& pointer) {
    if (isOfAlbedo(material.medium) && !material.albedo && mesh.colors.empty())
      throw badInput({file, "", pointer + "/medium/reflectance"},
                     "the albedo is what the medium reflects, and there is none",
                     "\"albedo\", or a mesh with colours at its vertices",
                     "give the material an \"albedo\", or leave \"reflectance\" out");
  };
  if (materials.by_name.empty()) require(materials.base, "");
  for (const auto& [name, material] : materials.by_name) require(material, childPointer("/materials", name));
}

// Takes the albedos of what consists of a medium whose reflectance they are off the surface.
void moveIntoMedia(const TriangleMesh& mesh, const std::string& mesh_file, SurfaceMaterials& surface) {
  if (std::none_of(surface.media.begin(), surface.media.end(), isOfAlbedo)) return;
  surface.medium_reflectance.assign(mesh.vertexCount(), {1, 1, 1});
  if (surface.vertex_albedo.empty()) surface.vertex_albedo.assign(mesh.vertexCount(), surface.albedo);
  std::vector<std::uint8_t> taken(mesh.vertexCount(), 0);
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    if (!isOfAlbedo(surface.media[surface.of_triangle.empty() ? 0 : surface.of_triangle[t]])) continue;
    for (const std::uint32_t vertex : mesh.triangles[t]) {
      if (taken[vertex] != 0) continue;
      taken[vertex] = 1;
      std::swap(surface.medium_reflectance[vertex], surface.vertex_albedo[vertex]);
      for (const float value : surface.medium_reflectance[vertex])
        if (!std::isfinite(value))
          throw badInput({mesh_file, "vertex " + std::to_string(vertex), ""},
                         "its color is not finite, and the medium would reflect that", "numbers from 0 to 1");
    }
  }
  if (std::all_of(surface.media.begin(), surface.media.end(), isOfAlbedo)) {
    surface.albedo = {1, 1, 1};
    surface.vertex_albedo.clear();
  }
}

}  // namespace

const Material& Materials::of(const std::string& name) const {
  const auto found = by_name.find(name);
  return found == by_name.end() ? base : found->second;
}

FileResolver relativeTo(fs::path folder) {
  return [folder = std::move(folder)](const std::string& name, const ErrorPlace& place) {
    const fs::path path = (folder / name).lexically_normal();
    if (!fs::is_regular_file(path))
      throw badInput(place, "there is no file " + path.string(), "",
                     "write its path relative to the folder of this file");
    return path;
  };
}

Material materialFromJson(const Json& json, const std::string& file, const std::string& pointer,
                          const FileResolver& files) {
  return materialFrom(JsonReader(json, file, pointer), files);
}

Materials materialsFromJson(const Json& json, const std::string& file, const std::string& pointer,
                            const FileResolver& files) {
  const JsonReader object(json, file, pointer);
  if (!object.has("material") && !object.has("materials"))
    return {materialFromJson(json, file, pointer, files)};
  Materials materials;
  if (const auto base = object.find("material")) materials.base = materialFrom(*base, files);
  const JsonReader named = object.object("materials");
  for (const std::string& name : named.keys()) {
    const Material material = materialFrom(named.at(name), files);
    if (!material.texture.empty())
      throw named.at(name).at("albedo").error("a texture of one of several materials is not read from here",
                                              "three numbers from 0 to 1",
                                              "name the picture in the mesh's own material");
    materials.by_name[name] = material;
  }
  object.refuseOthers();
  return materials;
}

Materials readMaterials(const fs::path& path) {
  Materials materials = materialsFromJson(readJson(path), path.string(), "", relativeTo(path.parent_path()));
  readTable(materials.base);
  for (auto& [name, material] : materials.by_name) readTable(material);
  return materials;
}

std::vector<std::string> translucentMaterials(const Materials& materials) {
  std::vector<std::string> names;
  if (materials.base.medium) names.emplace_back();
  for (const auto& [name, material] : materials.by_name)
    if (material.medium) names.push_back(name);
  return names;
}

Materials readMaterialsOrDefault(const fs::path& path) {
  return path.empty() ? Materials() : readMaterials(path);
}

Json toJson(const Materials& materials, const std::vector<std::string>& parts) {
  Json json = {{"material", toJson(materials.base, parts)}};
  for (const auto& [name, material] : materials.by_name) json["materials"][name] = toJson(material, parts);
  return json;
}

const char* nameOf(const Reflection& reflection) {
  return kModels[reflection.index()].text;
}

PackPart runtimeLobe(const Reflection& reflection) {
  return std::visit(Overloaded{[](const Lambert&) -> PackPart { return LambertReflection(); },
                               [](const PhongReflection& phong) -> PackPart {
                                 return PhongLobe{static_cast<float>(phong.exponent), phong.specular_color};
                               },
                               [](const GgxReflection& ggx) -> PackPart {
                                 return GgxLobe{static_cast<float>(ggx.roughness), ggx.specular_color};
                               },
                               [](const TableReflection& table) -> PackPart { return table.table; }},
                    reflection);
}

std::string brdfTensorOf(const std::string& material) {
  return material.empty() ? "brdf" : "brdf/" + material;
}

BrdfTable brdfTableFrom(const TensorFile& tensors, const std::string& file, const std::string& material) {
  const std::string remedy = "make it with the brdf tool of this version";
  for (const auto& [key, expected] :
       {std::pair("basis", "real_sh_cartesian"), std::pair("frame", "local"), std::pair("cosine", "inside")})
    if (const std::string& found = tensors.requireMetadata(key, file); found != expected)
      throw badInput({file, std::string("metadata ") + key, ""}, "it is '" + found + "'",
                     std::string("'") + expected + "'", remedy);
  const std::string& digits = tensors.requireMetadata("order", file);
  BrdfTable table;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), table.order);
  if (status != std::errc() || end != digits.data() + digits.size() || table.order < 1 || table.order > 10)
    throw badInput({file, "metadata order", ""}, "it is '" + digits + "'", "1 to 10", remedy);
  const bool has_own = tensors.tensors.contains(brdfTensorOf(material));
  const std::string name = has_own ? brdfTensorOf(material) : brdfTensorOf("");
  const Tensor& tensor = tensors.require(name, ElementType::kFloat32, 3, file);
  const auto coefficients = static_cast<std::uint64_t>(table.order) * static_cast<std::uint64_t>(table.order);
  if (tensor.shape[0] < 1 || tensor.shape[1] != 3 || tensor.shape[2] != coefficients)
    throw badInput({file, "tensor " + name, ""}, "its shape does not fit the order " + digits,
                   "angles × red, green, blue × order²", remedy);
  const auto values = tensor.as<float>();
  table.angles = static_cast<int>(tensor.shape[0]);
  table.values.assign(values.begin(), values.end());
  return table;
}

BrdfTable readBrdfTable(const fs::path& path) {
  return brdfTableFrom(readSafetensors(path), path.string());
}

const Reflection* SurfaceMaterials::only() const {
  if (of_triangle.empty()) return &reflections.front();
  const Reflection& first = reflections[of_triangle.front()];
  const bool same = std::all_of(of_triangle.begin(), of_triangle.end(),
                                [&](std::uint32_t i) { return reflections[i] == first; });
  return same ? &first : nullptr;
}

SurfaceMaterials materialsOn(const TriangleMesh& mesh, const Materials& materials,
                             const std::string& mesh_file, const std::string& material_file) {
  requireNames(mesh, materials, material_file);
  requireColors(mesh, materials, material_file);
  SurfaceMaterials surface;
  surface.reflections = {materials.base.reflection};
  surface.media = {materials.base.medium};
  if (materials.by_name.empty()) {
    surface.albedo = materials.base.albedo.value_or(albedoWithoutColors(materials.base));
    if (!materials.base.albedo) surface.vertex_albedo = mesh.colors;
    surface.replaces_colors = materials.base.albedo && !mesh.colors.empty();
    moveIntoMedia(mesh, mesh_file, surface);
    return surface;
  }
  requireMaterials(mesh);
  VertexAlbedo albedo(mesh, mesh_file);
  surface.reflections.clear();
  surface.media.clear();
  surface.names = mesh.material_names;
  for (const std::string& name : mesh.material_names) {
    const Material& material = materials.of(name);
    surface.reflections.push_back(material.reflection);
    surface.media.push_back(material.medium);
    surface.replaces_colors = surface.replaces_colors || (material.albedo && !mesh.colors.empty());
  }
  surface.of_triangle = mesh.triangle_materials;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    const std::uint32_t number = mesh.triangle_materials[t];
    const std::string& name = mesh.material_names[number];
    for (const std::uint32_t vertex : mesh.triangles[t])
      albedo.give(vertex, name, number, materials.of(name));
  }
  surface.vertex_albedo = albedo.take();
  moveIntoMedia(mesh, mesh_file, surface);
  return surface;
}

}  // namespace bakelight::formats
