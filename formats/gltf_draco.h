// KHR_draco_mesh_compression. Private to the glTF reader.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "formats/gltf_accessors.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

class GltfDraco {
 public:
  // `extension`: the object of that name in a primitive. Throws Error(kBadInput) at its pointer if Draco
  // cannot decode what it refers to.
  GltfDraco(GltfDocument& document, const JsonReader& extension);
  ~GltfDraco();

  std::size_t vertexCount() const;
  std::vector<Triangle> triangles() const;

  // The attribute of that name ("POSITION"), if it is compressed; `accessor` says whether integers are
  // normalised. Throws if it has not as many components as one of `types`.
  std::optional<GltfNumbers> numbers(const std::string& name, const JsonReader& accessor,
                                     std::initializer_list<GltfType> types) const;

 private:
  struct Decoded;
  JsonReader extension_;
  std::unique_ptr<Decoded> decoded_;
};

}  // namespace bakelight::formats
