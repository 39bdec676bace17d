// The nodes of a glTF file, and the skins that they move. Private to the glTF reader.
#pragma once

#include <vector>

#include "formats/gltf_document.h"
#include "formats/gltf_primitives.h"
#include "formats/mesh_transform.h"

namespace bakelight::formats {

class GltfScene {
 public:
  // Throws Error(kBadInput) if the nodes form no forest, or a transform is malformed.
  GltfScene(GltfDocument& document, std::vector<std::string>& notes);

  // The nodes to be drawn, parents first: those below the default scene, else below the first scene, else
  // all.
  const std::vector<std::size_t>& nodes() const { return nodes_; }
  const Transform& worldFromNode(std::size_t node) const { return world_from_node_[node]; }

 private:
  void readNodes();
  void findWorld();
  std::vector<std::size_t> rootNodes(std::vector<std::string>& notes) const;
  void collect(std::vector<std::size_t> roots, std::vector<std::string>& notes);

  GltfDocument& document_;
  std::vector<Transform> world_from_node_;  // of each node
  std::vector<std::vector<std::size_t>> children_;
  std::vector<bool> has_parent_;
  std::vector<std::size_t> nodes_;
};

// The copies of a node that EXT_mesh_gpu_instancing asks for, as transforms within it; without the extension
// the identity only.
std::vector<Transform> instancesOf(GltfDocument& document, const JsonReader& node);

// The joints of a skin, at the pose of their nodes.
class GltfSkin {
 public:
  GltfSkin(GltfDocument& document, const JsonReader& skin, const GltfScene& scene);

  // Moves the primitive's vertices into the world, as the weights of its joints say (normalised); a vertex
  // without weight follows its first joint. Triangles that a mirroring joint turned over are turned back:
  // `mirrored` says if there were any. Throws if a joint does not exist.
  MeshPart place(const GltfPrimitive& primitive, bool& mirrored, std::size_t& unweighted) const;

 private:
  Transform blended(const GltfPrimitive& primitive, std::size_t vertex, std::size_t& unweighted) const;

  JsonReader skin_;
  std::vector<Transform> world_from_bind_;  // of each joint
};

}  // namespace bakelight::formats
