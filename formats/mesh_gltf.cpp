#include "formats/mesh_gltf.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/gltf_document.h"
#include "formats/gltf_materials.h"
#include "formats/gltf_primitives.h"
#include "formats/gltf_scene.h"

namespace bakelight::formats {
namespace {

std::string counted(std::size_t count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

class GltfReader {
 public:
  GltfReader(const std::filesystem::path& path, const Bytes& bytes)
      : document_(path, bytes, result_.notes),
        materials_(document_),
        meshes_(document_, materials_),
        scene_(document_, result_.notes) {}

  MeshParts read() {
    for (const std::size_t node : scene_.nodes()) addNode(node);
    if (document_.count("nodes") == 0) addMeshesWithoutNodes();
    addNotes();
    materials_.moveTo(result_);
    return std::move(result_);
  }

 private:
  void addNode(std::size_t index) {
    const JsonReader node = document_.item("nodes", index);
    const auto mesh = node.find("mesh");
    if (!mesh) return;
    const auto primitives = meshes_.get(document_.indexAt(*mesh, "meshes"), node);
    if (const auto skin = node.find("skin")) {
      addSkinned(node, *skin, *primitives);
      return;
    }
    for (const Transform& node_from_instance : instancesOf(document_, node)) {
      const Transform world_from_instance = scene_.worldFromNode(index) * node_from_instance;
      for (const GltfPrimitive& primitive : *primitives) add(primitive, world_from_instance, node);
    }
  }

  // A library of meshes: each as it is.
  void addMeshesWithoutNodes() {
    for (std::size_t i = 0; i < document_.count("meshes"); ++i) {
      const JsonReader mesh = document_.item("meshes", i);
      const auto primitives = meshes_.get(i, mesh);
      for (const GltfPrimitive& primitive : *primitives) add(primitive, Transform{}, mesh);
    }
  }

  void add(const GltfPrimitive& primitive, const Transform& world, const JsonReader& owner) {
    MeshPart part = primitive.part;
    mirrored_ += place(primitive.positions, primitive.normals, world, part);
    finish(std::move(part), primitive, owner);
  }

  // The node's own transform does not matter (glTF 2.0, 3.7.3.3).
  void addSkinned(const JsonReader& node, const JsonReader& reference,
                  const GltfMeshes::Primitives& primitives) {
    if (extensionOf(node, "EXT_mesh_gpu_instancing")) {
      throw node.error("it has both a skin and instances (EXT_mesh_gpu_instancing)", "one of the two");
    }
    const JsonReader skin = document_.referred(reference, "skins");
    const std::size_t index = document_.indexAt(reference, "skins");
    auto& kept = skins_.try_emplace(index, document_, skin, scene_).first->second;
    for (const GltfPrimitive& primitive : primitives) {
      if (primitive.influences == 0) {
        throw reference.error("the node has a skin, but " + primitive.pointer + " has no JOINTS_0",
                              "JOINTS_0 and WEIGHTS_0 in each primitive");
      }
      bool mirrored = false;
      MeshPart part = kept.place(primitive, mirrored, unweighted_);
      mirrored_ += mirrored;
      finish(std::move(part), primitive, node);
    }
  }

  void finish(MeshPart part, const GltfPrimitive& primitive, const JsonReader& owner) {
    if (const auto vertex = firstNotFinite(part.positions)) {
      const auto& source = primitive.positions[*vertex];
      const bool is_finite =
          std::all_of(source.begin(), source.end(), [](double v) { return std::isfinite(v); });
      const std::string name = owner.text("name", "");
      throw badInput({document_.file(),
                      "vertex " + std::to_string(*vertex) + " of the primitive" +
                          (name.empty() ? "" : " in '" + name + "'") + " (" + owner.pointer() + ")",
                      primitive.pointer + "/attributes/POSITION"},
                     is_finite ? "its place in the scene is beyond the range of 32-bit floats"
                               : "its position is not finite",
                     "three numbers", "repair the mesh in its modelling program");
    }
    vertices_ += part.positions.size();
    if (vertices_ > std::numeric_limits<std::uint32_t>::max()) {
      throw badInput({document_.file(), "", owner.pointer()},
                     "the scene has more than 4,294,967,295 vertices", "32-bit vertex indices",
                     "divide it into several files");
    }
    result_.parts.push_back(std::move(part));
  }

  void note(const std::string& text) { result_.notes.push_back(text); }

  void addNotes() {
    const GltfCounts& counts = meshes_.counts();
    if (counts.points_and_lines > 0) {
      note(counted(counts.points_and_lines, "primitive of points or lines was",
                   "primitives of points or lines were") +
           " left out");
    }
    if (counts.leftover_corners > 0) {
      note(counted(counts.leftover_corners, "corner was", "corners were") + " left over, and left out");
    }
    if (counts.colors_as_codes > 0) {
      note("vertex colours are integers that are not marked as normalised: taken as if they were");
    }
    if (mirrored_ > 0) {
      note(counted(mirrored_, "part is", "parts are") +
           " mirrored by a transform: the triangles were turned over");
    }
    if (unweighted_ > 0) {
      note(counted(unweighted_, "vertex has", "vertices have") +
           " no joint weights, and follow the first joint");
    }
    if (document_.count("animations") > 0) note("animations were left out: the file's rest pose was read");
  }

  MeshParts result_;
  GltfDocument document_;
  GltfMaterials materials_;
  GltfMeshes meshes_;
  GltfScene scene_;
  std::map<std::size_t, GltfSkin> skins_;
  std::size_t mirrored_ = 0, unweighted_ = 0, vertices_ = 0;
};

}  // namespace

MeshParts readGltf(const std::filesystem::path& path, const Bytes& bytes) {
  return GltfReader(path, bytes).read();
}

}  // namespace bakelight::formats
