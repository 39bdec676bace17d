#include "formats/mesh_assimp.h"

#include <assimp/BaseImporter.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "formats/assimp_materials.h"
#include "formats/assimp_orientation.h"
#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_transform.h"
#include "formats/polygon.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

std::string counted(std::size_t count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

Transform transformOf(const aiMatrix4x4& m) {
  return {{{{m.a1, m.a2, m.a3}, {m.b1, m.b2, m.b3}, {m.c1, m.c2, m.c3}}}, {m.a4, m.b4, m.c4}};
}

std::vector<Double3> toDouble3(const aiVector3D* values, unsigned count) {
  std::vector<Double3> result(count);
  for (unsigned i = 0; i < count; ++i) result[i] = {values[i].x, values[i].y, values[i].z};
  return result;
}

class SceneReader {
 public:
  SceneReader(const aiScene& scene, const std::filesystem::path& path)
      : scene_(scene), path_(path), materials_(assimpMaterials(scene, path, result_.notes)) {}

  MeshParts read() {
    const Transform upright = uprightFromScene(scene_, lowerEnding(path_), result_.notes);
    // No recursion: a damaged file may nest nodes deeper than the stack.
    std::vector<std::pair<const aiNode*, Transform>> stack = {{scene_.mRootNode, upright}};
    while (!stack.empty()) {
      const auto [node, world_from_parent] = stack.back();
      stack.pop_back();
      const Transform world_from_node = world_from_parent * transformOf(node->mTransformation);
      for (unsigned i = 0; i < node->mNumMeshes; ++i) addMesh(*node, node->mMeshes[i], world_from_node);
      for (unsigned i = node->mNumChildren; i-- > 0;) stack.emplace_back(node->mChildren[i], world_from_node);
    }
    addNotes();
    result_.materials = std::move(materials_.materials);
    result_.textures = std::move(materials_.textures);
    return std::move(result_);
  }

 private:
  Error error(const std::string& element, const std::string& what, const std::string& expected) const {
    return badInput({path_.string(), element, ""}, what, expected, "export the file again");
  }

  void addMesh(const aiNode& node, unsigned index, const Transform& world_from_node) {
    if (index >= scene_.mNumMeshes) {
      throw error("node '" + std::string(node.mName.C_Str()) + "'", "it names a mesh that does not exist",
                  "");
    }
    const aiMesh& mesh = *scene_.mMeshes[index];
    const std::string name = "mesh " + std::to_string(index) +
                             (mesh.mName.length == 0 ? "" : " '" + std::string(mesh.mName.C_Str()) + "'");
    MeshPart part;
    part.material =
        mesh.mMaterialIndex < materials_.places.size() ? materials_.places[mesh.mMaterialIndex] : -1;
    addTriangles(mesh, name, part);
    addTexcoords(mesh, name, part);
    if (mesh.HasVertexColors(0)) {
      for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        part.colors.push_back({mesh.mColors[0][i].r, mesh.mColors[0][i].g, mesh.mColors[0][i].b});
      }
    }
    const auto normals =
        mesh.HasNormals() ? toDouble3(mesh.mNormals, mesh.mNumVertices) : std::vector<Double3>{};
    mirrored_ += place(toDouble3(mesh.mVertices, mesh.mNumVertices), normals, world_from_node, part);
    if (const auto vertex = firstNotFinite(part.positions)) {
      throw error("vertex " + std::to_string(*vertex) + " of " + name, "its position is not finite",
                  "three numbers");
    }
    result_.parts.push_back(std::move(part));
  }

  // assimp's own triangulation fails an assertion on a face without corners.
  void addTriangles(const aiMesh& mesh, const std::string& name, MeshPart& part) {
    std::vector<Float3> corners;
    std::vector<Triangle> triangles;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      checkFace(face, mesh, "face " + std::to_string(i) + " of " + name);
      if (face.mNumIndices < 3) {
        ++points_and_lines_;
        continue;
      }
      corners.clear();
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const aiVector3D& p = mesh.mVertices[face.mIndices[k]];
        corners.push_back({p.x, p.y, p.z});
      }
      triangles.clear();
      if (face.mNumIndices == 3) {
        triangles.push_back({0, 1, 2});
      } else {
        doubtful_ += !triangulator_.triangulate(corners, triangles);
      }
      for (const Triangle& t : triangles) {
        part.triangles.push_back({face.mIndices[t[0]], face.mIndices[t[1]], face.mIndices[t[2]]});
      }
    }
  }

  void checkFace(const aiFace& face, const aiMesh& mesh, const std::string& element) const {
    if (face.mNumIndices == 0) throw error(element, "it has no corner", "at least three");
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= mesh.mNumVertices) {
        throw error(element, "it names a vertex that does not exist",
                    "indices below " + std::to_string(mesh.mNumVertices));
      }
      const aiVector3D& p = mesh.mVertices[face.mIndices[k]];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        throw error(element, "the position of vertex " + std::to_string(face.mIndices[k]) + " is not finite",
                    "three numbers");
      }
    }
  }

  void addTexcoords(const aiMesh& mesh, const std::string& name, MeshPart& part) {
    if (mesh.HasTextureCoords(0)) part.texcoords = texcoords(mesh, AssimpLookup{});
    if (part.material < 0) return;
    auto lookup = materials_.lookups[static_cast<std::size_t>(part.material)];
    if (!lookup || lookup->isPlain()) return;
    if (lookup->set >= AI_MAX_NUMBER_OF_TEXTURECOORDS || !mesh.HasTextureCoords(lookup->set)) {
      if (part.texcoords.empty()) return;  // told with the picture, once all parts are there
      note(name + " has no set " + std::to_string(lookup->set) +
           " of texture coordinates, in which the material '" +
           materials_.materials[static_cast<std::size_t>(part.material)].name +
           "' looks its picture up: set 0 is taken");
      lookup->set = 0;
    }
    part.texture_lookups = texcoords(mesh, *lookup);
  }

  static std::vector<Float2> texcoords(const aiMesh& mesh, const AssimpLookup& lookup) {
    std::vector<Float2> result(mesh.mNumVertices);
    const double cosine = std::cos(lookup.rotation), sine = std::sin(lookup.rotation);
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& t = mesh.mTextureCoords[lookup.set][i];
      double u = lookup.scale[0] * t.x, v = lookup.scale[1] * t.y;
      if (lookup.rotation != 0) {
        const double x = u - 0.5, y = v - 0.5;
        u = cosine * x - sine * y + 0.5, v = sine * x + cosine * y + 0.5;
      }
      result[i] = {static_cast<float>(u + lookup.offset[0]), static_cast<float>(v + lookup.offset[1])};
    }
    return result;
  }

  void addNotes() {
    if (points_and_lines_ > 0) {
      note(counted(points_and_lines_, "point or line was", "points and lines were") + " left out");
    }
    if (doubtful_ > 0) {
      note(counted(doubtful_, "polygon has", "polygons have") +
           " no area or cross themselves; their triangles are a guess");
    }
    if (mirrored_ > 0) {
      note(counted(mirrored_, "part is", "parts are") +
           " mirrored by a transform: the triangles were turned over");
    }
    if (scene_.mNumAnimations > 0) note("animations were left out: the file's rest pose was read");
  }

  void note(const std::string& text) { result_.notes.push_back(text); }

  const aiScene& scene_;
  const std::filesystem::path& path_;
  MeshParts result_;
  AssimpMaterials materials_;
  PolygonTriangulator triangulator_;
  std::size_t points_and_lines_ = 0, doubtful_ = 0, mirrored_ = 0;
};

// assimp tries its readers by content where an ending is unknown to it.
void leaveOutOurFormats(Assimp::Importer& importer) {
  for (const char* ending : {"obj", "ply", "stl", "off", "gltf", "glb"}) {
    while (Assimp::BaseImporter* reader = importer.GetImporter(ending)) {
      importer.UnregisterLoader(reader);
      delete reader;  // it is ours now
    }
  }
}

// assimp reads a 3DS file that was cut short as far as it goes. Its first chunk is the whole file, and has
// its length in bytes 2 to 5.
void checkLengthOf3ds(const std::filesystem::path& path) {
  const Bytes bytes = readFile(path);
  std::uint32_t length = 0;
  constexpr std::size_t kPlace = 2;
  if (bytes.size() >= kPlace + sizeof length) std::memcpy(&length, bytes.data() + kPlace, sizeof length);
  if (bytes.size() >= kPlace + sizeof length && length <= bytes.size()) return;
  throw badInput(
      {path.string(), "", ""},
      "the file has " + std::to_string(bytes.size()) + " bytes, its header says " + std::to_string(length),
      "as many bytes as the header says", "copy or export the file again, it was probably cut short");
}

// As UTF-8, which assimp 5.2 wants.
std::string textOfCollada(const std::filesystem::path& path) {
  std::string text = readTextFile(path);
  auto converted = utf8FromUtf16(text);
  return converted ? std::move(*converted) : text;
}

// assimp 5.2 never returns from a COLLADA index list with anything but digits in it.
void checkIndicesOfCollada(const std::string& text, const std::filesystem::path& path) {
  constexpr std::string_view kLists[] = {"p", "h", "v", "vcount"};
  for (std::size_t open = text.find('<'); open != std::string::npos; open = text.find('<', open + 1)) {
    const std::size_t name_end = text.find_first_of(" \t\r\n>/", open + 1);
    const std::size_t close = text.find('>', open);
    if (name_end == std::string::npos || close == std::string::npos || text[close - 1] == '/') continue;
    const std::string_view name(&text[open + 1], name_end - open - 1);
    if (std::find(std::begin(kLists), std::end(kLists), name) == std::end(kLists)) continue;
    const std::size_t wrong = text.find_first_not_of("0123456789+- \t\r\n", close + 1);
    if (wrong == std::string::npos || text[wrong] == '<') continue;
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(wrong), '\n');
    throw badInput({path.string(), "line " + std::to_string(line), ""},
                   "the list <" + std::string(name) + "> holds '" + text[wrong] + "'", "integers",
                   "export the file again");
  }
}

}  // namespace

MeshParts readWithAssimp(const std::filesystem::path& path) {
  if (lowerEnding(path) == ".3ds") checkLengthOf3ds(path);
  const bool is_collada = lowerEnding(path) == ".dae";
  const std::string collada = is_collada ? textOfCollada(path) : "";
  if (is_collada) checkIndicesOfCollada(collada, path);
  Assimp::Importer importer;
  leaveOutOurFormats(importer);
  const auto unreadable = [&](const std::string& why) {
    return badInput({path.string(), "", ""}, "it cannot be read as a mesh (" + why + ")",
                    "a whole OBJ, PLY, STL, OFF, glTF, FBX, DAE or 3DS file", "export it again");
  };
  const aiScene* scene = nullptr;
  try {
    scene = is_collada ? importer.ReadFileFromMemory(collada.data(), collada.size(), 0, "dae")
                       : importer.ReadFile(path.string(), 0);
  } catch (const std::exception& error) {  // numbers or sizes of a damaged file
    throw unreadable(error.what());
  }
  if (scene == nullptr) throw unreadable(importer.GetErrorString());
  if (scene->mRootNode == nullptr) throw unreadable("it has no scene");
  return SceneReader(*scene, path).read();
}

}  // namespace bakelight::formats
