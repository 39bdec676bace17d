#include "formats/mesh_obj.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/error.h"
#include "formats/mesh_corners.h"
#include "formats/obj_materials.h"
#include "formats/obj_statements.h"
#include "formats/polygon_mesh.h"
#include "formats/vertex_colors.h"

namespace bakelight::formats {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class ObjAssembler {
 public:
  ObjAssembler(ObjStatements statements, ObjMaterials materials, std::string file)
      : obj_(std::move(statements)), materials_(std::move(materials)), file_(std::move(file)) {}

  MeshParts assemble() {
    checkUse();
    readColors();
    dropTexturesWithoutCoordinates();
    triangulate();
    makeVertices();
    MeshParts result;
    result.notes = std::move(obj_.notes);
    result.notes.insert(result.notes.end(), materials_.notes.begin(), materials_.notes.end());
    result.materials = std::move(materials_.materials);
    result.textures = std::move(materials_.textures);
    result.parts.push_back(std::move(part_));
    return result;
  }

 private:
  void note(std::string text) { obj_.notes.push_back(std::move(text)); }

  // Which vertices faces name: they must be finite, and the others are left out.
  //
  // A cut inside the last number leaves a well-formed line. Such a file lacks its last line end, and, as the
  // last faces are missing, has vertices that none uses: the last ones, as faces mostly name vertices in
  // their order. A whole file with both is rare enough to ask for its line end.
  void checkUse() {
    std::vector<bool> used(obj_.positions.size());
    std::size_t unused = obj_.positions.size();
    for (const ObjCorner& corner : obj_.corners) {
      unused -= !used[corner.vertex - 1];
      used[corner.vertex - 1] = true;
    }
    for (const ObjStatements::NotFinite& vertex : obj_.not_finite)
      if (used[vertex.vertex])
        throw badInput(
            {file_, "line " + std::to_string(vertex.line), ""},
            "the position of vertex " + std::to_string(vertex.vertex + 1) + " (counted from 1) is not finite",
            "three numbers that a 32-bit float can hold", "repair the mesh in its modelling program");
    if (obj_.corner_counts.empty())
      throw badInput({file_, "", ""},
                     "it has no triangle, only " + counted(obj_.positions.size(), "vertex", "vertices") +
                         (obj_.notes.empty() ? "" : "; " + obj_.notes.front()),
                     "a mesh with at least one face", "export it again as a surface of polygons");
    const std::string unused_text = std::to_string(unused) + " of " + std::to_string(obj_.positions.size()) +
                                    " vertices belong to no face";
    std::size_t unused_last = 0;
    while (unused_last < used.size() && !used[used.size() - 1 - unused_last]) ++unused_last;
    if (unused_last > 0 && 2 * unused_last >= unused && obj_.ends_inside_line)
      throw badInput({file_, "line " + std::to_string(obj_.line_count), ""},
                     "the file ends inside a line, and " + unused_text, "a line end at the end",
                     "copy or export the file again, it was probably cut short; if it is whole, add the "
                     "line end");
    if (unused > 0)
      note(unused_text + ", and were left out: was the file cut short?");
    else if (obj_.ends_inside_line)
      note("the last line has no line end: was the file cut short?");
  }

  void readColors() {
    if (obj_.colors.empty()) return;
    ColorRange range;
    std::size_t without = 0;
    for (const Float3& color : obj_.colors) {
      if (std::isnan(color[0]))
        ++without;
      else
        range.add(color);
    }
    const float white = range.isOfBytes() ? 255.0F : 1.0F;
    if (range.isOfBytes()) note("vertex colours go beyond 1: they were read as 8-bit codes, 255 is white");
    if (without > 0)
      note(std::to_string(without) + " of " + std::to_string(obj_.colors.size()) +
           " vertices have no colour, and were taken as white");
    for (Float3& color : obj_.colors) {
      if (std::isnan(color[0])) {
        color = {1, 1, 1};
        continue;
      }
      for (float& value : color) value = linearFromSrgb(value / white);
    }
  }

  // Without coordinates a texture cannot be looked up. Where only some corners have none, they are taken at
  // its origin, as renderers do.
  void dropTexturesWithoutCoordinates() {
    std::vector<std::size_t> with(materials_.materials.size()), without(materials_.materials.size());
    const ObjCorner* corner = obj_.corners.data();
    for (std::size_t face = 0; face < obj_.corner_counts.size(); ++face)
      for (std::uint32_t k = 0; k < obj_.corner_counts[face]; ++k, ++corner)
        if (obj_.face_materials[face] >= 0)
          ++(corner->texcoord != 0 ? with : without)[static_cast<std::size_t>(obj_.face_materials[face])];
    bool any_texture = false;
    for (std::size_t m = 0; m < materials_.materials.size(); ++m) {
      PartMaterial& material = materials_.materials[m];
      if (material.texture < 0) continue;
      if (with[m] > 0) {
        corners_without_lookup_ += without[m];
        any_texture = true;
        continue;
      }
      if (without[m] > 0)
        note("the texture of the material '" + material.name +
             "' was left out: its faces have no texture coordinates");
      material.texture = -1;
    }
    if (!any_texture) materials_.textures.clear();
    if (corners_without_lookup_ > 0)
      note(counted(corners_without_lookup_, "corner of a textured face has",
                   "corners of textured faces have") +
           " no texture coordinates, and the colour of the texture's lower left");
  }

  void triangulate() {
    FaceTriangles faces = triangulateFaces(
        obj_.corner_counts,
        [&](std::uint32_t corner) { return obj_.positions[obj_.corners[corner].vertex - 1]; }, obj_.notes);
    part_.triangles = std::move(faces.triangles);
    if (obj_.materials.empty()) return;
    for (const std::uint32_t face : faces.faces)
      part_.triangle_materials.push_back(obj_.face_materials[face]);
  }

  void makeVertices() {
    const bool indexed_apart =
        std::any_of(obj_.corners.begin(), obj_.corners.end(),
                    [](const ObjCorner& corner) { return corner.texcoord != 0 || corner.normal != 0; });
    if (indexed_apart) {
      makeVerticesOfCorners();
      return;
    }
    part_.positions = std::move(obj_.positions);
    part_.colors = std::move(obj_.colors);
    for (Triangle& triangle : part_.triangles)
      for (std::uint32_t& corner : triangle) corner = obj_.corners[corner].vertex - 1;
    keepUsedVertices(part_);
  }

  // A vertex belongs to one material if that moves the texture.
  std::uint32_t lookupOf(int material) const {
    if (material < 0) return 0;
    const auto m = static_cast<std::size_t>(material);
    const MtlTexture& lookup = materials_.lookups[m];
    const bool moved = lookup.scale != Float2{1, 1} || lookup.offset != Float2{0, 0};
    return materials_.materials[m].texture >= 0 && moved ? static_cast<std::uint32_t>(material) + 1 : 0;
  }

  void makeVerticesOfCorners() {
    CornerTable table;
    for (std::size_t t = 0; t < part_.triangles.size(); ++t) {
      const std::uint32_t lookup = obj_.materials.empty() ? 0 : lookupOf(part_.triangle_materials[t]);
      for (std::uint32_t& vertex : part_.triangles[t]) {
        const ObjCorner& corner = obj_.corners[vertex];
        vertex = table.numberOf({corner.vertex, corner.texcoord, corner.normal, lookup});
      }
    }
    obj_.corners = {};
    fillVertices(table.corners());
  }

  void fillVertices(const std::vector<CornerTable::Corner>& corners) {
    const auto with = [&](std::size_t slot) {
      return static_cast<std::size_t>(
          std::count_if(corners.begin(), corners.end(),
                        [&](const CornerTable::Corner& corner) { return corner[slot] != 0; }));
    };
    const std::size_t texcoord_count = with(1), normal_count = with(2);
    const bool has_lookups = with(3) > 0 || (!materials_.textures.empty() && texcoord_count < corners.size());
    const bool has_texcoords = isForAll(texcoord_count, corners.size(), "texture coordinates");
    const bool has_normals = isForAll(normal_count, corners.size(), "normals");
    for (const auto& [vertex, texcoord, normal, lookup] : corners) {
      part_.positions.push_back(obj_.positions[vertex - 1]);
      if (!obj_.colors.empty()) part_.colors.push_back(obj_.colors[vertex - 1]);
      if (has_normals) part_.normals.push_back(obj_.normals[normal - 1]);
      const Float2 uv = texcoord == 0 ? Float2{kNan, kNan} : obj_.texcoords[texcoord - 1];
      if (has_texcoords) part_.texcoords.push_back(uv);
      if (has_lookups) part_.texture_lookups.push_back(movedLookup(uv, lookup));
    }
  }

  // A mesh has an attribute on every vertex or on none.
  bool isForAll(std::size_t with, std::size_t count, const char* what) {
    if (with > 0 && with < count)
      note(std::string(what) + " were left out: " + std::to_string(count - with) + " of " +
           std::to_string(count) + " corners of faces have none");
    return with == count;
  }

  Float2 movedLookup(const Float2& uv, std::uint32_t lookup) const {
    if (std::isnan(uv[0])) return {0, 0};
    if (lookup == 0) return uv;
    const MtlTexture& moved = materials_.lookups[lookup - 1];
    return {uv[0] * moved.scale[0] + moved.offset[0], uv[1] * moved.scale[1] + moved.offset[1]};
  }

  ObjStatements obj_;
  ObjMaterials materials_;
  std::string file_;
  MeshPart part_;
  std::size_t corners_without_lookup_ = 0;
};

}  // namespace

MeshParts readObj(std::string_view text, const std::filesystem::path& file, const FileLookup& files) {
  ObjStatements statements = readObjStatements(text, file.string());
  ObjMaterials materials =
      objMaterials(statements.materials, statements.libraries, file.parent_path(), files);
  return ObjAssembler(std::move(statements), std::move(materials), file.string()).assemble();
}

}  // namespace bakelight::formats
