// What a surface is made of: a file of its own (docs/FORMATS.md, "Materials"), or a part of asset.json. All
// that looks at a material reads it here.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/medium.h"
#include "formats/pack_contents.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

struct TensorFile;

// What is reflected besides the diffuse part.

struct Lambert {  // nothing
  bool operator==(const Lambert&) const = default;
};

// (exponent + 1)/2π · cos^exponent around the mirror direction, times the specular colour.
struct PhongReflection {
  Float3 specular_color = {0.2F, 0.2F, 0.2F};  // 0–1
  double exponent = 32;                        // 0–100,000
  bool operator==(const PhongReflection&) const = default;
};

// Microfacets of the GGX distribution, alpha = roughness² (transport/microfacet.h).
struct GgxReflection {
  Float3 specular_color = {0.2F, 0.2F, 0.2F};  // reflectance of a microfacet, 0–1
  double roughness = 0.3;                      // 0–1; 0 is a mirror
  bool fresnel = false;                        // reflectance rises to 1 towards grazing angles (Schlick 1994)
  bool multiple_scattering = false;            // between microfacets; without it, that light is lost
  bool operator==(const GgxReflection&) const = default;
};

// Any isotropic BRDF, projected by the tool `brdf`.
struct TableReflection {
  std::filesystem::path file;
  BrdfTable table;  // of order 0 until it is read
  bool operator==(const TableReflection& other) const { return file == other.file; }
};

using Reflection = std::variant<Lambert, PhongReflection, GgxReflection, TableReflection>;

// A patch's surface as a picture of heights.
struct PatchHeight {
  std::filesystem::path file;
  double depth = 0.1;  // from its black to its white, in widths of the patch
  bool operator==(const PatchHeight&) const = default;
};

// A patch's surface as a mesh.
struct PatchMesh {
  std::filesystem::path file;
  enum class Up { kZ, kY } up = Up::kZ;  // what points out of the patch
  // Of the box that repeats, across and up the patch, in the mesh's unit; nothing: the mesh's bounds.
  std::optional<std::array<double, 2>> period;
  bool operator==(const PatchMesh&) const = default;
};

// Structure that is repeated over a surface: an image of any channels that mesomesh lays out, a surface that
// rtt renders, or both.
struct Patch {
  std::filesystem::path file;   // the image; may be empty where there is a surface
  std::optional<double> width;  // in the asset's unit, positive; nothing: as the meso-mesh's spacing suits it
  bool periodic = true;         // its left continues its right and its top its bottom
  // At most one of the two.
  std::optional<PatchHeight> height = {};
  std::optional<PatchMesh> geometry = {};
  // Instead of a surface: a texture that is made already, by rtt or of a measured BTF by btf; the first in the file.
  std::filesystem::path rtt = {};
  // Or a measured BTF, a `.btf` file or a zip of pictures, of which btf makes one.
  std::filesystem::path btf = {};
  // Of the surface: a picture over the patch times the albedo, where there is either.
  std::filesystem::path texture = {};
  std::optional<Float3> albedo = {};

  // Flat, with the picture as its colors, where there is neither height nor geometry.
  bool hasSurface() const {
    return rtt.empty() && btf.empty() && (height || geometry || !file.empty() || !texture.empty());
  }
  bool operator==(const Patch&) const = default;
};

inline constexpr Float3 kDefaultAlbedo = {0.8F, 0.8F, 0.8F};

struct Material {
  std::string name;
  // Diffuse reflectance, linear, 0–1. Nothing: the mesh's colours, or kDefaultAlbedo where it has none.
  std::optional<Float3> albedo;
  std::filesystem::path texture;  // instead; `simplify` takes it to the mesh's colours
  Reflection reflection;
  std::optional<Patch> patch = {};
  // In place of diffuse reflection: what the object is inside. The albedo, 1 without one, is then a stain on its surface, or what the medium reflects
  // (ReflectanceSource).
  std::optional<Medium> medium = {};
};

// The material of an asset, and those of faces that the mesh gives a name to (TriangleMesh::material_names).
struct Materials {
  Material base;
  std::map<std::string, Material> by_name = {};

  const Material& of(const std::string& name) const;  // `base` if there is none of that name
};

// What a file name in a material means. Throws Error(kBadInput) at the place if there is no such file.
using FileResolver = std::function<std::filesystem::path(const std::string& name, const ErrorPlace& place)>;
// Relative to `folder`.
FileResolver relativeTo(std::filesystem::path folder);

// One material, or { "material": one, "materials": { name: one } }, of which either may be missing. Tables
// are read. Throws Error(kBadInput) naming file and JSON pointer for an unknown key (with the nearest one), a
// wrong type or a value out of range, and as readBrdfTable.
Materials readMaterials(const std::filesystem::path& path);
// "" is the asset's own.
std::vector<std::string> translucentMaterials(const Materials& materials);
// As readMaterials, with no material at all where the path is empty: grey, without reflection.
Materials readMaterialsOrDefault(const std::filesystem::path& path);
// Without reading tables.
Materials materialsFromJson(const Json& json, const std::string& file, const std::string& pointer,
                            const FileResolver& files);
Material materialFromJson(const Json& json, const std::string& file, const std::string& pointer,
                          const FileResolver& files);

// What readMaterials reads, file names as they are in the material. Of each material only the members
// `parts`, of "name", "albedo" (with the texture), "reflection", "patch" and "medium" (with the albedo where that is its reflectance); all of them if it is empty.
Json toJson(const Materials& materials, const std::vector<std::string>& parts = {});

// "none", "phong", "ggx", "table".
const char* nameOf(const Reflection& reflection);

// What the player takes for a reflection at run time: GGX becomes a lobe that is symmetric around the mirror
// direction.
PackPart runtimeLobe(const Reflection& reflection);

// What the tool `brdf` writes: the table of whatever reflects, in the tensor "brdf"; where materials reflect
// differently, those of names in tensors of their own.
std::string brdfTensorOf(const std::string& material);  // "brdf/NAME"; "brdf" of no name
// That of the material, else the one for all. Throws Error(kBadInput) naming tensor or key.
BrdfTable brdfTableFrom(const TensorFile& tensors, const std::string& file, const std::string& material = "");
BrdfTable readBrdfTable(const std::filesystem::path& path);

// The materials of one mesh, as its vertices and triangles have them.
struct SurfaceMaterials {
  std::vector<Reflection> reflections = {Lambert()};  // at least one
  std::vector<std::string> names = {""};              // of the materials that have them
  std::vector<std::optional<Medium>> media = {{}};    // of the same
  std::vector<std::uint32_t> of_triangle;             // into `reflections`; empty: all have the first
  Float3 albedo = kDefaultAlbedo;                     // where `vertex_albedo` is empty
  std::vector<Float3> vertex_albedo;                  // empty, or one a vertex
  // Of each vertex, where some medium's reflectance is the albedo: that, 0–1, or what is beyond; 1 at other vertices. The albedos above are 1 there.
  std::vector<Float3> medium_reflectance = {};
  bool replaces_colors = false;  // the mesh has colours, and a material's albedo instead of them

  // That of all triangles that there are; nothing if they differ.
  const Reflection* only() const;
};

// Throws Error(kBadInput): naming `material_file` for a material of a name that no face has, or a texture
// that the mesh has no colours of, or a medium whose reflectance is an albedo that there is none of; naming `mesh_file` where a vertex belongs to faces of different albedo
// (`simplify` gives each its own), or such a medium's albedo is not finite.
SurfaceMaterials materialsOn(const TriangleMesh& mesh, const Materials& materials,
                             const std::string& mesh_file, const std::string& material_file);

}  // namespace bakelight::formats
