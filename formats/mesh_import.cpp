#include "formats/mesh_import.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <limits>
#include <string_view>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_content.h"
#include "formats/mesh_obj.h"
#include "formats/mesh_off.h"
#include "formats/mesh_parts.h"
#include "formats/mesh_stl.h"
#include "formats/named_file.h"
#include "formats/ply_parts.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

std::string plural(std::size_t count, const std::string& singular, const std::string& plural_form) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural_form);
}

// Affine, in double: a chain of node transforms must not cost float bits.
struct Transform {
  double linear[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double offset[3] = {0, 0, 0};

  bool isIdentity() const {
    for (int row = 0; row < 3; ++row) {
      if (offset[row] != 0) return false;
      for (int column = 0; column < 3; ++column) {
        if (linear[row][column] != (row == column ? 1 : 0)) return false;
      }
    }
    return true;
  }
};

Transform transformOf(const aiMatrix4x4& m) {
  return {{{m.a1, m.a2, m.a3}, {m.b1, m.b2, m.b3}, {m.c1, m.c2, m.c3}}, {m.a4, m.b4, m.c4}};
}

Transform parentFromNodeChild(const Transform& outer, const Transform& inner) {
  Transform result;
  for (int row = 0; row < 3; ++row) {
    result.offset[row] = outer.offset[row];
    for (int k = 0; k < 3; ++k) result.offset[row] += outer.linear[row][k] * inner.offset[k];
    for (int column = 0; column < 3; ++column) {
      result.linear[row][column] = 0;
      for (int k = 0; k < 3; ++k)
        result.linear[row][column] += outer.linear[row][k] * inner.linear[k][column];
    }
  }
  return result;
}

// Cofactors: they carry normals (up to length), and their first row gives the determinant.
struct NormalTransform {
  double cofactor[3][3];
  double determinant = 0;

  explicit NormalTransform(const Transform& t) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        const int r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
        cofactor[row][column] = t.linear[r1][c1] * t.linear[r2][c2] - t.linear[r1][c2] * t.linear[r2][c1];
      }
    }
    for (int column = 0; column < 3; ++column) determinant += t.linear[0][column] * cofactor[0][column];
  }
};

class Merger {
 public:
  Merger(const aiScene& scene, std::string file) : scene_(scene), file_(std::move(file)) {}

  MeshImport merge() {
    visitNode(*scene_.mRootNode, Transform{});
    finish();
    return std::move(result_);
  }

 private:
  Error error(const std::string& element, const std::string& what, const std::string& expected) const {
    return badInput({file_, element, ""}, what, expected, "repair the mesh in its modelling program");
  }

  void visitNode(const aiNode& node, const Transform& parent) {
    const Transform world_from_node = parentFromNodeChild(parent, transformOf(node.mTransformation));
    for (unsigned i = 0; i < node.mNumMeshes; ++i) addMesh(*scene_.mMeshes[node.mMeshes[i]], world_from_node);
    for (unsigned i = 0; i < node.mNumChildren; ++i) visitNode(*node.mChildren[i], world_from_node);
  }

  void addMesh(const aiMesh& source, const Transform& world_from_node) {
    TriangleMesh& mesh = result_.mesh;
    const std::size_t base = mesh.positions.size();
    if (base + source.mNumVertices > std::numeric_limits<std::uint32_t>::max()) {
      throw error("", "it has more than 4,294,967,295 vertices", "32-bit vertex indices");
    }
    ++mesh_count_;
    const NormalTransform normals(world_from_node);
    addPositions(source, world_from_node);
    addNormals(source, world_from_node, normals);
    addTexcoords(source);
    addColors(source);
    addTriangles(source, base, normals.determinant < 0);
  }

  void addPositions(const aiMesh& source, const Transform& world_from_node) {
    const bool moved = !world_from_node.isIdentity();
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      const aiVector3D& p = source.mVertices[i];
      Float3 position = {p.x, p.y, p.z};
      if (moved) {
        for (int row = 0; row < 3; ++row) {
          position[row] =
              static_cast<float>(world_from_node.linear[row][0] * p.x + world_from_node.linear[row][1] * p.y +
                                 world_from_node.linear[row][2] * p.z + world_from_node.offset[row]);
        }
      }
      checkFinite(position, "position");
      result_.mesh.positions.push_back(position);
    }
  }

  void checkFinite(const Float3& value, const char* what) const {
    if (std::all_of(value.begin(), value.end(), [](float v) { return std::isfinite(v); })) return;
    throw error("vertex " + std::to_string(result_.mesh.positions.size()),
                std::string("its ") + what + " is not finite", "three numbers");
  }

  void addNormals(const aiMesh& source, const Transform& world_from_node, const NormalTransform& normals) {
    if (!source.HasNormals()) {
      ++meshes_without_normals_;
      return;
    }
    const bool moved = !world_from_node.isIdentity();
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      const aiVector3D& n = source.mNormals[i];
      double v[3] = {n.x, n.y, n.z};
      if (moved) {
        for (int row = 0; row < 3; ++row) {
          v[row] = normals.cofactor[row][0] * n.x + normals.cofactor[row][1] * n.y +
                   normals.cofactor[row][2] * n.z;
        }
      }
      const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
      if (!(length > 0) || !std::isfinite(length)) {
        ++unusable_normals_;
        result_.mesh.normals.push_back({0, 0, 0});
        continue;
      }
      // A mirroring transform turns triangles over (addTriangles turns them back), so normals keep their
      // side.
      const double scale = (normals.determinant < 0 ? -1 : 1) / length;
      result_.mesh.normals.push_back({static_cast<float>(v[0] * scale), static_cast<float>(v[1] * scale),
                                      static_cast<float>(v[2] * scale)});
    }
  }

  void addTexcoords(const aiMesh& source) {
    if (!source.HasTextureCoords(0)) {
      ++meshes_without_texcoords_;
      return;
    }
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      const aiVector3D& t = source.mTextureCoords[0][i];
      unusable_texcoords_ += !(std::isfinite(t.x) && std::isfinite(t.y));
      result_.mesh.texcoords.push_back({t.x, t.y});
    }
  }

  void addColors(const aiMesh& source) {
    if (!source.HasVertexColors(0)) {
      ++meshes_without_colors_;
      return;
    }
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
      const aiColor4D& c = source.mColors[0][i];
      Float3 color = {c.r, c.g, c.b};
      bool clamped = false;
      for (float& value : color) {
        unusable_colors_ += !std::isfinite(value);
        clamped |= value < 0 || value > 1;
        value = std::clamp(value, 0.0F, 1.0F);
      }
      clamped_colors_ += clamped;
      result_.mesh.colors.push_back(color);
    }
  }

  void addTriangles(const aiMesh& source, std::size_t base, bool mirrored) {
    mirrored_meshes_ += mirrored;
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
      const aiFace& face = source.mFaces[i];
      if (face.mNumIndices != 3) {
        ++points_and_lines_;
        continue;
      }
      Triangle triangle;
      for (int corner = 0; corner < 3; ++corner) {
        triangle[corner] = static_cast<std::uint32_t>(base + face.mIndices[corner]);
      }
      if (mirrored) std::swap(triangle[1], triangle[2]);
      result_.mesh.triangles.push_back(triangle);
    }
  }

  void finish() {
    TriangleMesh& mesh = result_.mesh;
    if (mesh.triangles.empty()) {
      throw badInput({file_, "", ""}, "it has no triangle", "a mesh with at least one face",
                     "export it again as a surface; a file that was cut short also looks like this");
    }
    if (mesh_count_ > 1) note(std::to_string(mesh_count_) + " meshes were merged");
    if (scene_.mNumMaterials > 1) note(std::to_string(scene_.mNumMaterials) + " materials were merged");
    if (points_and_lines_ > 0)
      note(plural(points_and_lines_, "point or line was", "points and lines were") + " left out");
    if (mirrored_meshes_ > 0) {
      note(plural(mirrored_meshes_, "mesh is", "meshes are") +
           " mirrored by a node transform: the triangles were turned over");
    }
    if (!mesh.normals.empty() && (meshes_without_normals_ > 0 || unusable_normals_ > 0)) {
      note(unusable_normals_ > 0
               ? "normals were left out: " + std::to_string(unusable_normals_) + " of them have no direction"
               : "normals were left out: " + std::to_string(meshes_without_normals_) + " of " +
                     std::to_string(mesh_count_) + " meshes have none");
      mesh.normals.clear();
    }
    if (!mesh.texcoords.empty() && (meshes_without_texcoords_ > 0 || unusable_texcoords_ > 0)) {
      note("texture coordinates were left out: not every vertex has usable ones");
      mesh.texcoords.clear();
    }
    finishColors();
  }

  void finishColors() {
    if (result_.mesh.colors.empty()) return;
    if (meshes_without_colors_ > 0 || unusable_colors_ > 0) {
      note("vertex colours were left out: not every vertex has a usable one");
      result_.mesh.colors.clear();
    } else if (clamped_colors_ > 0) {
      note(plural(clamped_colors_, "vertex colour was", "vertex colours were") +
           " outside 0 to 1, and clamped");
    }
  }

  void note(std::string text) { result_.notes.push_back(std::move(text)); }

  const aiScene& scene_;
  std::string file_;
  MeshImport result_;
  std::size_t mesh_count_ = 0, mirrored_meshes_ = 0, points_and_lines_ = 0;
  std::size_t meshes_without_normals_ = 0, unusable_normals_ = 0;
  std::size_t meshes_without_texcoords_ = 0, unusable_texcoords_ = 0;
  std::size_t meshes_without_colors_ = 0, unusable_colors_ = 0, clamped_colors_ = 0;
};

void checkCorners(const aiScene& scene, const std::string& file) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      const auto in_range = [&](unsigned index) { return index < mesh.mNumVertices; };
      if (face.mNumIndices > 0 && std::all_of(face.mIndices, face.mIndices + face.mNumIndices, in_range))
        continue;
      throw badInput({file, "face " + std::to_string(i), ""},
                     face.mNumIndices == 0 ? "it has no corner" : "it names a vertex that does not exist",
                     "indices below " + std::to_string(mesh.mNumVertices), "export the file again");
    }
  }
}

MeshImport importWithAssimp(const std::filesystem::path& path) {
  const std::string file = path.string();
  Assimp::Importer importer;
  const auto unreadable = [&] {
    return badInput({file, "", ""},
                    std::string("it cannot be read as a mesh (") + importer.GetErrorString() + ")",
                    "a whole OBJ, PLY, STL, OFF, glTF or 3DS file", "export it again");
  };
  const aiScene* scene = importer.ReadFile(file, 0);
  if (scene == nullptr || scene->mRootNode == nullptr) throw unreadable();
  checkCorners(*scene, file);
  // Only now, as it fails an assertion on a face without corners.
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) throw unreadable();
  MeshImport result = Merger(*scene, file).merge();
  // assimp's 3DS reader does so by the root node's transform: (x, y, z) becomes (x, z, −y).
  if (lowerEnding(path) == ".3ds") result.notes.push_back("3DS files have +Z up: turned to +Y up");
  return result;
}

// One reader a format.
MeshParts readParts(const std::filesystem::path& path, const std::string& ending,
                    std::span<const std::byte> bytes) {
  const std::string file = path.string();
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (ending == ".obj") return readObj(text, path, filesOnDisk());
  if (ending == ".ply")
    return readPlyParts(bytes.last(withoutByteOrderMark(text).size()), path, filesOnDisk());
  if (ending == ".stl") return readStl(bytes, file);
  return readOff(bytes, file);
}

bool hasReader(const std::string& ending) {
  return ending == ".obj" || ending == ".ply" || ending == ".stl" || ending == ".off";
}

}  // namespace

MeshImport importMesh(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  const std::string ending = lowerEnding(path);
  checkMeshContent(bytes, ending, path.string());
  if (!hasReader(ending)) return importWithAssimp(path);
  {
    const auto converted = utf8FromUtf16({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    if (converted)
      return merged(readParts(path, ending, std::as_bytes(std::span(*converted))), path.string());
  }
  return merged(readParts(path, ending, bytes), path.string());
}

const std::vector<std::string>& meshFileEndings() {
  static const std::vector<std::string> endings = {".obj", ".ply", ".stl", ".off", ".gltf", ".glb", ".3ds"};
  return endings;
}

}  // namespace bakelight::formats
