// The albedo of glTF's materials. Private to the glTF reader.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "formats/gltf_document.h"
#include "formats/mesh_parts.h"

namespace bakelight::formats {

// How a material looks its picture up.
struct GltfLookup {
  std::uint64_t set = 0;  // of TEXCOORD_n
  // KHR_texture_transform, in glTF's frame (origin at the upper left): rows of a 2 × 3 matrix.
  std::array<std::array<double, 3>, 2> transform = {{{1, 0, 0}, {0, 1, 0}}};

  bool isPlain() const { return *this == GltfLookup{}; }
  bool operator==(const GltfLookup&) const = default;
};

class GltfMaterials {
 public:
  // Names of all materials.
  explicit GltfMaterials(GltfDocument& document);

  // Reads the material at its first use, so that faults of others do not matter. Returns how its picture is
  // looked up, if it has one.
  const std::optional<GltfLookup>& use(std::size_t index);

  // Hands over materials, textures and notes.
  void moveTo(MeshParts& parts);

 private:
  struct Material {
    bool is_read = false;
    std::optional<GltfLookup> lookup;
  };

  void read(const JsonReader& material, PartMaterial& result, std::optional<GltfLookup>& lookup);
  // −1, and noted, if its picture is not there.
  int textureAt(const JsonReader& reference, const PartMaterial& material);
  JsonReader imageOf(const JsonReader& texture, std::size_t& image_index);
  std::optional<AlbedoTexture> pictureAt(const JsonReader& image, std::size_t index) const;

  GltfDocument& document_;
  std::vector<Material> read_;
  std::vector<PartMaterial> materials_;
  std::vector<AlbedoTexture> textures_;
  std::map<std::tuple<std::size_t, AlbedoTexture::Wrap, AlbedoTexture::Wrap>, int> texture_of_image_;
  std::vector<std::string> see_through_;  // names
  std::vector<std::string> notes_;
};

}  // namespace bakelight::formats
