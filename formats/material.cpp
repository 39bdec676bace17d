#include "formats/material.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/json_members.h"
#include "formats/materials.h"
#include "formats/tensors.h"

namespace bakelight::formats {
namespace {

namespace fs = std::filesystem;

constexpr JsonMembers::Range kShare = {0, 1}, kExponent = {0, 100000},
                             kWidth = {std::numeric_limits<double>::min(), 1e15};
constexpr const char* kColorOrTexture = "three numbers from 0 to 1, or the file name of a picture";
const std::vector<std::string> kModels = {"none", "phong", "ggx", "table"};

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

fs::path fileNamed(const Json& text, const ErrorPlace& place, const FileResolver& files) {
  return files(text.get<std::string>(), place);
}

Reflection reflectionFrom(const Json& json, const std::string& file, const std::string& pointer,
                          const FileResolver& files) {
  JsonMembers members(json, file, pointer);
  const std::size_t model = members.readChoice("model", kModels);
  Reflection reflection = Lambert{};
  if (model == 1) {
    PhongReflection phong;
    members.read("specular_color", phong.specular_color, kShare);
    members.read("exponent", phong.exponent, kExponent);
    reflection = phong;
  } else if (model == 2) {
    GgxReflection ggx;
    members.read("specular_color", ggx.specular_color, kShare);
    members.read("roughness", ggx.roughness, kShare);
    members.read("fresnel", ggx.fresnel);
    members.read("multiple_scattering", ggx.multiple_scattering);
    reflection = ggx;
  } else if (model == 3) {
    const std::string expected = "a file of the brdf tool";
    std::string name;
    members.require("file", expected);
    members.read("file", name);
    reflection = TableReflection{files(name, members.placeOf("file")), {}};
  }
  members.refuseOthers();
  return reflection;
}

Patch patchFrom(const Json& json, const std::string& file, const std::string& pointer,
                const FileResolver& files) {
  JsonMembers members(json, file, pointer);
  std::string name;
  members.require("file", "a picture");
  members.read("file", name);
  Patch patch{files(name, members.placeOf("file")), {}};
  if (members.find("width") != nullptr) {
    double width = 0;
    members.read("width", width, kWidth);
    patch.width = width;
  }
  members.read("periodic", patch.periodic);
  members.refuseOthers();
  return patch;
}

void readTable(Material& material) {
  if (auto* table = std::get_if<TableReflection>(&material.reflection))
    table->table = readBrdfTable(table->file);
}

// The shortest text that means the same float.
Json numbersOf(const Float3& values) {
  Json numbers = Json::array();
  for (const float value : values) {
    char text[32];
    const auto written = std::to_chars(text, text + sizeof text, value);
    double number = 0;
    std::from_chars(text, written.ptr, number);
    numbers.push_back(number);
  }
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
  Json json = {{"file", patch.file.string()}, {"periodic", patch.periodic}};
  if (patch.width) json["width"] = *patch.width;
  return json;
}

Json toJson(const Material& material, const std::vector<std::string>& parts) {
  const auto wanted = [&](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  Json json = Json::object();
  if (wanted("name") && !material.name.empty()) json["name"] = material.name;
  if (wanted("albedo") && material.albedo) json["albedo"] = numbersOf(*material.albedo);
  if (wanted("albedo") && !material.texture.empty()) json["albedo"] = material.texture.string();
  if (wanted("reflection") && !std::holds_alternative<Lambert>(material.reflection))
    json["reflection"] = toJson(material.reflection);
  if (wanted("patch") && material.patch) json["patch"] = toJson(*material.patch);
  return json;
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
                          : mesh_.colors.empty() ? kDefaultAlbedo
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
  JsonMembers members(json, file, pointer);
  Material material;
  members.read("name", material.name);
  if (const Json* albedo = members.find("albedo")) {
    const ErrorPlace place = members.placeOf("albedo");
    if (albedo->is_string())
      material.texture = fileNamed(*albedo, place, files);
    else if (albedo->is_array())
      material.albedo = JsonMembers::triple(*albedo, "albedo", kShare, place);
    else
      throw badInput(place, albedo->dump() + " is no albedo", kColorOrTexture);
  }
  if (const Json* reflection = members.find("reflection"))
    material.reflection = reflectionFrom(*reflection, file, members.placeOf("reflection").pointer, files);
  if (const Json* patch = members.find("patch"))
    material.patch = patchFrom(*patch, file, members.placeOf("patch").pointer, files);
  members.refuseOthers();
  return material;
}

Materials materialsFromJson(const Json& json, const std::string& file, const std::string& pointer,
                            const FileResolver& files) {
  if (!json.is_object() || !(json.contains("material") || json.contains("materials")))
    return {materialFromJson(json, file, pointer, files)};
  JsonMembers members(json, file, pointer);
  Materials materials;
  if (const Json* base = members.find("material"))
    materials.base = materialFromJson(*base, file, members.placeOf("material").pointer, files);
  const std::string inner = members.placeOf("materials").pointer;
  static const Json kNone = Json::object();
  const Json* const given = members.find("materials");
  const Json& named = given == nullptr ? kNone : *given;
  const JsonMembers names(named, file, inner);
  for (const std::string& name : names.names()) {
    const Material material = materialFromJson(named.at(name), file, names.placeOf(name).pointer, files);
    if (!material.texture.empty())
      throw badInput({file, "", childPointer(names.placeOf(name).pointer, "albedo")},
                     "a texture of one of several materials is not read from here",
                     "three numbers from 0 to 1", "name the picture in the mesh's own material");
    materials.by_name[name] = material;
  }
  members.refuseOthers();
  return materials;
}

Materials readMaterials(const fs::path& path) {
  Materials materials = materialsFromJson(readJson(path), path.string(), "", relativeTo(path.parent_path()));
  readTable(materials.base);
  for (auto& [name, material] : materials.by_name) readTable(material);
  return materials;
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
  return kModels[reflection.index()].c_str();
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
  if (materials.by_name.empty()) {
    surface.albedo = materials.base.albedo.value_or(kDefaultAlbedo);
    if (!materials.base.albedo) surface.vertex_albedo = mesh.colors;
    surface.replaces_colors = materials.base.albedo && !mesh.colors.empty();
    return surface;
  }
  requireMaterials(mesh);
  VertexAlbedo albedo(mesh, mesh_file);
  surface.reflections.clear();
  surface.names = mesh.material_names;
  for (const std::string& name : mesh.material_names) {
    const Material& material = materials.of(name);
    surface.reflections.push_back(material.reflection);
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
  return surface;
}

}  // namespace bakelight::formats
