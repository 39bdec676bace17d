// The primitives of glTF's meshes, before nodes and skins move them. Private to the glTF reader.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "formats/gltf_document.h"
#include "formats/gltf_materials.h"
#include "formats/mesh_transform.h"

namespace bakelight::formats {

struct GltfPrimitive {
  std::vector<Double3> positions, normals;  // morph targets applied
  MeshPart part;                            // all but positions and normals
  // Of each vertex `influences` joints of the skin (unchecked) and their weights; 0 without a skin.
  std::size_t influences = 0;
  std::vector<std::uint32_t> joints;
  std::vector<double> weights;
  std::string pointer;  // "/meshes/0/primitives/1"
};

// What was met on the way and deserves a note.
struct GltfCounts {
  std::size_t points_and_lines = 0;  // primitives
  std::size_t leftover_corners = 0;
  std::size_t colors_as_codes = 0;  // primitives
};

class GltfMeshes {
 public:
  GltfMeshes(GltfDocument& document, GltfMaterials& materials);

  using Primitives = std::vector<GltfPrimitive>;
  // Those of the mesh `index` that have triangles, with the morph weights of `node`, else of the mesh. Kept
  // for other nodes that ask for the same.
  std::shared_ptr<const Primitives> get(std::size_t index, const JsonReader& node);

  const GltfCounts& counts() const { return counts_; }

 private:
  GltfDocument& document_;
  GltfMaterials& materials_;
  GltfCounts counts_;
  std::map<std::pair<std::size_t, std::vector<double>>, std::shared_ptr<const Primitives>> kept_;
  std::vector<std::size_t> users_;  // how many nodes have the mesh
};

}  // namespace bakelight::formats
