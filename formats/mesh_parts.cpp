#include "formats/mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

std::string counted(std::size_t count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

template <std::size_t n>
bool isFinite(const std::array<float, n>& value) {
  return std::all_of(value.begin(), value.end(), [](float v) { return std::isfinite(v); });
}

// Returns whether the color had to be clamped.
bool clampColor(Float3& color) {
  const Float3 given = color;
  for (float& value : color) value = std::clamp(value, 0.0F, 1.0F);
  return color != given;
}

// The vertices of a part once more than one material may not share them.
struct SplitPart {
  std::vector<std::uint32_t> source;  // of each vertex: the vertex of the part
  std::vector<int> material;          // of each vertex; −1 also where no triangle uses it
  std::vector<Triangle> triangles;
};

int materialOf(const MeshPart& part, std::size_t triangle) {
  return part.triangle_materials.empty() ? part.material : part.triangle_materials[triangle];
}

SplitPart splitByMaterial(const MeshPart& part) {
  constexpr int kUnused = std::numeric_limits<int>::min();
  SplitPart split;
  split.source.resize(part.positions.size());
  for (std::uint32_t i = 0; i < split.source.size(); ++i) split.source[i] = i;
  split.material.assign(part.positions.size(), kUnused);
  split.triangles = part.triangles;
  std::map<std::pair<std::uint32_t, int>, std::uint32_t> copies;
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    const int material = materialOf(part, t);
    for (std::uint32_t& corner : split.triangles[t]) {
      int& owner = split.material[corner];
      if (owner == kUnused) owner = material;
      if (owner == material) continue;
      const auto [copy, is_new] =
          copies.try_emplace({corner, material}, static_cast<std::uint32_t>(split.source.size()));
      if (is_new) {
        split.source.push_back(split.source[corner]);
        split.material.push_back(material);
      }
      corner = copy->second;
    }
  }
  std::replace(split.material.begin(), split.material.end(), kUnused, -1);
  return split;
}

class Merger {
 public:
  Merger(MeshParts parts, const std::string& file) : input_(std::move(parts)), file_(file) {}

  MeshImport merge() {
    std::erase_if(input_.parts, [](const MeshPart& part) { return part.triangles.empty(); });
    if (input_.parts.empty()) {
      throw badInput({file_, "", ""}, "it has no triangle", "a mesh with at least one face",
                     "export it again as a surface");
    }
    result_.notes = std::move(input_.notes);
    if (input_.parts.size() > 1) note(std::to_string(input_.parts.size()) + " parts were merged");
    findUsedMaterials();
    decideAttributes();
    for (MeshPart& part : input_.parts) {
      add(part);
      part = {};  // so that the whole is not held twice
    }
    finishMaterials();
    noteCounts();
    return std::move(result_);
  }

 private:
  void note(std::string text) { result_.notes.push_back(std::move(text)); }

  const PartMaterial* materialAt(int index) const {
    return index < 0 ? nullptr : &input_.materials[static_cast<std::size_t>(index)];
  }
  int textureOf(int material) const { return material < 0 ? -1 : materialAt(material)->texture; }

  void findUsedMaterials() {
    used_.assign(input_.materials.size(), false);
    const auto mark = [&](int material) {
      if (material < 0) {
        has_triangles_without_ = true;
      } else {
        used_[static_cast<std::size_t>(material)] = true;
      }
    };
    for (const MeshPart& part : input_.parts) {
      if (part.triangle_materials.empty()) mark(part.material);
      for (const int material : part.triangle_materials) mark(material);
    }
    has_materials_ = std::find(used_.begin(), used_.end(), true) != used_.end();
  }

  // Which attributes the mesh will have.
  void decideAttributes() {
    for (PartMaterial& material : input_.materials) {
      if (material.color && !isFinite(*material.color)) material.color.reset(), ++unusable_material_colors_;
    }
    decideNormals();
    decideTexcoords();
    decideColors();
    for (std::size_t m = 0; m < used_.size(); ++m) {
      if (!used_[m]) continue;
      with_colors_ |= input_.materials[m].color.has_value();
      with_textures_ |= input_.materials[m].texture >= 0;
    }
  }

  std::size_t countParts(bool (*has)(const MeshPart&)) const {
    return static_cast<std::size_t>(std::count_if(input_.parts.begin(), input_.parts.end(), has));
  }

  void decideNormals() {
    const std::size_t count = countParts([](const MeshPart& part) { return !part.normals.empty(); });
    if (count == 0) return;
    std::size_t unusable = 0;
    for (const MeshPart& part : input_.parts) {
      for (const Float3& n : part.normals) unusable += !isFinite(n) || n == Float3{0, 0, 0};
    }
    with_normals_ = count == input_.parts.size() && unusable == 0;
    if (with_normals_) return;
    note(unusable > 0 ? "normals were left out: " + std::to_string(unusable) + " of them have no direction"
                      : "normals were left out: " + missing(count) + " have none");
  }

  std::string missing(std::size_t present) const {
    return std::to_string(input_.parts.size() - present) + " of " + std::to_string(input_.parts.size()) +
           " parts";
  }

  void decideTexcoords() {
    const std::size_t count = countParts([](const MeshPart& part) { return !part.texcoords.empty(); });
    if (count == 0) return;
    std::size_t unusable = 0;
    for (const MeshPart& part : input_.parts) {
      for (const Float2& t : part.texcoords) unusable += !isFinite(t);
    }
    with_texcoords_ = count == input_.parts.size() && unusable == 0;
    if (with_texcoords_) return;
    note(unusable > 0
             ? "texture coordinates were left out: " + std::to_string(unusable) + " of them are not finite"
             : "texture coordinates were left out: " + missing(count) + " have none");
  }

  void decideColors() {
    std::size_t unusable = 0;
    bool any = false;
    for (const MeshPart& part : input_.parts) {
      any |= !part.colors.empty();
      for (const Float3& color : part.colors) unusable += !isFinite(color);
    }
    if (unusable > 0) {
      note("vertex colours were left out: " + std::to_string(unusable) + " of them are not finite");
      for (MeshPart& part : input_.parts) part.colors.clear();
    }
    with_colors_ = any && unusable == 0;
  }

  void add(const MeshPart& part) {
    const SplitPart split = splitByMaterial(part);
    TriangleMesh& mesh = result_.mesh;
    const std::size_t base = mesh.positions.size();
    if (base + split.source.size() > std::numeric_limits<std::uint32_t>::max()) {
      throw badInput({file_, "", ""}, "it has more than 4,294,967,295 vertices", "32-bit vertex indices",
                     "divide it into several meshes");
    }
    for (const std::uint32_t v : split.source) mesh.positions.push_back(part.positions[v]);
    if (with_normals_) {
      for (const std::uint32_t v : split.source) mesh.normals.push_back(unit(part.normals[v]));
    }
    if (with_texcoords_) {
      for (const std::uint32_t v : split.source) mesh.texcoords.push_back(part.texcoords[v]);
    }
    if (with_colors_) addColors(part, split);
    if (with_textures_) addLookups(part, split);
    addTriangles(part, split, static_cast<std::uint32_t>(base));
  }

  static Float3 unit(const Float3& n) {
    const double x = n[0], y = n[1], z = n[2], length = std::sqrt(x * x + y * y + z * z);
    return {static_cast<float>(x / length), static_cast<float>(y / length), static_cast<float>(z / length)};
  }

  void addColors(const MeshPart& part, const SplitPart& split) {
    for (std::size_t i = 0; i < split.source.size(); ++i) {
      Float3 color = {1, 1, 1};
      if (!part.colors.empty()) {
        color = part.colors[split.source[i]];
        clamped_colors_ += clampColor(color) && i < part.positions.size();
      }
      const PartMaterial* material = materialAt(split.material[i]);
      if (material != nullptr && material->color) {
        Float3 factor = *material->color;
        clampColor(factor);
        for (std::size_t c = 0; c < 3; ++c) color[c] *= factor[c];
      } else if (part.colors.empty() && textureOf(split.material[i]) < 0) {
        ++white_vertices_;
      }
      result_.mesh.colors.push_back(color);
    }
  }

  void addLookups(const MeshPart& part, const SplitPart& split) {
    const std::vector<Float2>& lookups = part.texture_lookups.empty() ? part.texcoords : part.texture_lookups;
    for (std::size_t i = 0; i < split.source.size(); ++i) {
      const int texture = textureOf(split.material[i]);
      if (texture >= 0) checkLookup(lookups, split.source[i], split.material[i], texture);
      result_.texture_lookups.push_back(texture < 0 ? Float2{0, 0} : lookups[split.source[i]]);
    }
  }

  void checkLookup(const std::vector<Float2>& lookups, std::uint32_t vertex, int material,
                   int texture) const {
    if (!lookups.empty() && isFinite(lookups[vertex])) return;
    const std::string& name = materialAt(material)->name;
    const std::string element =
        name.empty() ? "material " + std::to_string(material) : "material '" + name + "'";
    const std::string picture = input_.textures[static_cast<std::size_t>(texture)].name;
    throw badInput({file_, element, ""},
                   lookups.empty() ? "its texture (" + picture + ") has no texture coordinates to look it up"
                                   : "a coordinate for its texture (" + picture + ") is not finite",
                   "texture coordinates on every vertex of this material",
                   "unwrap the mesh, or take the texture off the material");
  }

  void addTriangles(const MeshPart& part, const SplitPart& split, std::uint32_t base) {
    TriangleMesh& mesh = result_.mesh;
    for (const Triangle& t : split.triangles)
      mesh.triangles.push_back({base + t[0], base + t[1], base + t[2]});
    if (!has_materials_) return;
    for (std::size_t t = 0; t < split.triangles.size(); ++t) {
      const int material = materialOf(part, t);
      mesh.triangle_materials.push_back(static_cast<std::uint32_t>(
          material < 0 ? input_.materials.size() : static_cast<std::size_t>(material)));
    }
  }

  void finishMaterials() {
    if (!has_materials_) return;
    for (std::size_t m = 0; m < used_.size(); ++m) {
      PartMaterial& material = input_.materials[m];
      clamped_materials_ += used_[m] && material.color && clampColor(*material.color);
      result_.mesh.material_names.push_back(std::move(material.name));
    }
    if (has_triangles_without_) result_.mesh.material_names.emplace_back();
    if (!with_textures_) return;
    result_.material_textures.assign(result_.mesh.material_names.size(), -1);
    std::map<int, int> kept;  // from the file's textures
    for (std::size_t m = 0; m < used_.size(); ++m) {
      const int texture = input_.materials[m].texture;
      if (!used_[m] || texture < 0) continue;
      const auto [place, is_new] = kept.try_emplace(texture, static_cast<int>(result_.textures.size()));
      if (is_new) {
        result_.textures.push_back(std::move(input_.textures[static_cast<std::size_t>(texture)]));
      }
      result_.material_textures[m] = place->second;
    }
  }

  void noteCounts() {
    if (clamped_colors_ > 0) {
      note(counted(clamped_colors_, "vertex colour was", "vertex colours were") +
           " outside 0 to 1, and clamped");
    }
    if (clamped_materials_ > 0) {
      note("the colour of " + counted(clamped_materials_, "material was", "materials was") +
           " outside 0 to 1, and clamped");
    }
    if (unusable_material_colors_ > 0) {
      note("the colour of " + counted(unusable_material_colors_, "material was", "materials was") +
           " left out: it is not finite");
    }
    if (white_vertices_ > 0) {
      note(counted(white_vertices_, "vertex has", "vertices have") +
           " no colour where others have one: white");
    }
  }

  MeshParts input_;
  const std::string& file_;
  MeshImport result_;
  std::vector<bool> used_;  // of the materials
  bool has_triangles_without_ = false, has_materials_ = false;
  bool with_normals_ = false, with_texcoords_ = false, with_colors_ = false, with_textures_ = false;
  std::size_t clamped_colors_ = 0, clamped_materials_ = 0, unusable_material_colors_ = 0, white_vertices_ = 0;
};

}  // namespace

MeshImport merged(MeshParts parts, const std::string& file) {
  return Merger(std::move(parts), file).merge();
}

}  // namespace bakelight::formats
