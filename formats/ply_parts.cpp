#include "formats/ply_parts.h"

#include <algorithm>
#include <cmath>

#include "formats/error.h"
#include "formats/gltf_uri.h"
#include "formats/missing_picture.h"
#include "formats/ply_contents.h"
#include "formats/ply_textures.h"
#include "formats/polygon_mesh.h"
#include "formats/text_scan.h"
#include "formats/vertex_colors.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

class PlyAssembler {
 public:
  PlyAssembler(const PlyHeader& header, PlyContents contents, std::string file)
      : ply_(std::move(contents)), file_(std::move(file)) {
    readMaterialNames(header);
    for (const std::string& line : header.unknown_lines)
      note("a line of the header is none of PLY's, and was left out: '" + line + "'");
  }

  MeshParts assemble(const std::vector<std::string>& textures, const fs::path& folder,
                     const FileLookup& files) {
    checkFaces();
    makeLinear(mesh_.colors, ply_.color_type, "vertex");
    makeLinear(mesh_.face_colors, ply_.face_color_type, "face");
    if (textures.empty())
      addMaterials();
    else
      addTextures(textures, folder, files);
    if (result_.materials.empty()) mesh_.face_materials.clear();
    result_.parts.push_back(partOf(std::move(mesh_), ply_.notes));
    result_.notes = std::move(ply_.notes);
    return std::move(result_);
  }

 private:
  void note(std::string text) { ply_.notes.push_back(std::move(text)); }

  void checkFaces() const {
    if (mesh_.corner_counts.empty())
      throw badInput(
          {file_, "", ""},
          "it has no face, only " + std::to_string(mesh_.positions.size()) + " vertices (a point cloud)",
          "an element face or tristrips", "reconstruct a surface from the points first");
    if (ply_.not_finite.empty()) return;
    std::vector<bool> used(mesh_.positions.size());
    for (const std::uint32_t vertex : mesh_.corners) used[vertex] = true;
    for (const auto& [vertex, line] : ply_.not_finite)
      if (used[vertex])
        throw badInput({file_,
                        "vertex " + std::to_string(vertex) + " (counted from 0" +
                            (line > 0 ? ", line " + std::to_string(line) : "") + ")",
                        ""},
                       "its position is not finite", "three numbers that a 32-bit float can hold",
                       "repair the mesh in its modelling program");
  }

  // The rule of formats/mesh_import.h: 8 bits are display codes, others are light.
  void makeLinear(std::vector<Float3>& colors, PlyScalar type, const std::string& whose) {
    if (colors.empty()) return;
    ColorRange range;
    for (const Float3& color : colors) range.add(color);
    const bool is_byte = type == PlyScalar::kUint8 || type == PlyScalar::kInt8;
    float white = 1;
    bool codes = is_byte;
    if (is_byte) {
      white = 255;
      for (Float3& color : colors)
        for (float& value : color)
          if (value < 0) value += 256;  // a byte whose type is written without its "u"
    } else if (isInteger(type)) {
      codes = range.largest() <= 255;
      white = codes ? 255 : 65535;
      if (codes) note(whose + " colours go up to 255: they were read as 8-bit codes");
    } else if (range.isOfBytes() && range.areWhole()) {
      codes = true;
      white = 255;
      note(whose + " colours are integers beyond 1: they were read as 8-bit codes");
    }
    for (Float3& color : colors)
      for (float& value : color) value = codes ? linearFromSrgb(value / white) : value / white;
  }

  // "comment material 0 red%20paint", as formats/mesh_ply.h writes it between stages.
  void readMaterialNames(const PlyHeader& header) {
    for (const std::string& comment : header.comments) {
      std::string_view rest = comment;
      if (takeWord(rest) != "material") continue;
      const auto number = parseInteger(takeWord(rest));
      if (number && *number == static_cast<std::int64_t>(material_names_.size()))
        material_names_.push_back(percentDecoded(takeWord(rest)));
    }
  }

  // Without names a number is another program's, and no material.
  void addMaterials() {
    if (mesh_.face_materials.empty() || material_names_.empty()) return;
    for (int& material : mesh_.face_materials)
      if (material >= static_cast<int>(material_names_.size())) material = -1;
    for (std::string& name : material_names_)
      result_.materials.push_back({.name = std::move(name), .color = {}, .texture = -1});
  }

  void addTextures(const std::vector<std::string>& names, const fs::path& folder, const FileLookup& files) {
    if (names.empty()) return;
    if (mesh_.corner_texcoords.empty() && mesh_.texcoords.empty()) {
      note("the texture " + names[0] + " was left out: there are no texture coordinates");
      return;
    }
    for (const std::string& name : names) {
      PartMaterial material{.name = name, .color = {}, .texture = -1};
      const auto found = findNamedFile(files, folder, name);
      if (!found) {
        note(missingPicture(file_, name, name, std::nullopt));
      } else {
        if (!found->exact) note("'" + name + "' is taken to mean " + found->path.filename().string());
        material.texture = static_cast<int>(result_.textures.size());
        result_.textures.push_back({.name = found->path.string(), .path = found->path});
      }
      result_.materials.push_back(std::move(material));
    }
    chooseTextures(static_cast<int>(names.size()));
  }

  void chooseTextures(int count) {
    if (mesh_.face_materials.empty()) {
      if (count > 1)
        note("faces do not say which of the " + std::to_string(count) +
             " textures is theirs: the first was taken");
      mesh_.face_materials.assign(mesh_.corner_counts.size(), 0);
    }
    std::size_t unknown = 0, begin = 0;
    for (std::size_t f = 0; f < mesh_.face_materials.size(); ++f) {
      int& texture = mesh_.face_materials[f];
      if (texture >= count) {
        ++unknown;
        texture = -1;
      }
      // A face without texture coordinates among others that have them.
      if (!mesh_.corner_texcoords.empty() && std::isnan(mesh_.corner_texcoords[begin][0])) texture = -1;
      begin += mesh_.corner_counts[f];
    }
    if (unknown > 0)
      note(counted(unknown, "face has", "faces have") +
           " the number of a texture that the header does not name, and no colour of it");
  }

  PlyContents ply_;
  PolygonMesh& mesh_ = ply_.mesh;
  std::string file_;
  std::vector<std::string> material_names_;
  MeshParts result_;
};

}  // namespace

MeshParts readPlyParts(std::span<const std::byte> bytes, const fs::path& file, const FileLookup& files) {
  const PlyHeader header = readPlyHeader(bytes, file.string());
  PlyContents contents = readPlyContents(header, bytes, file.string());
  return PlyAssembler(header, std::move(contents), file.string())
      .assemble(plyTextureNames(header), file.parent_path(), files);
}

}  // namespace bakelight::formats
