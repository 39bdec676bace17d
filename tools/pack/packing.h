// Puts a mesh and the transfer baked for it together as one pack. Pure: structs in, struct out.
#pragma once

#include <string>

#include "formats/pack.h"
#include "formats/tensors.h"
#include "formats/triangle_mesh.h"

namespace bakelight::packing {

// What the stage's files are called, for errors.
struct SourceNames {
  std::string mesh, transfer;
};

// `transfer` is the transfer stage's file (docs/FORMATS.md): tensor "transfer" of float32, vertices × order²,
// and metadata that say what is inside it. Throws Error(kBadInput) naming tensor or key if it says something
// that a pack of this version cannot hold, if its shape does not fit the mesh, or if it was baked for another
// mesh. The pack itself is judged by formats::encodePack.
formats::Pack assemblePack(formats::TriangleMesh mesh, const formats::TensorFile& transfer,
                           const std::string& name, const formats::Float3& albedo, const SourceNames& files);

// Throws Error(kBadInput) at /position_bits or /normal_bits: 0, or 8–30 and 6–30.
void checkOptions(const formats::PackOptions& options);

}  // namespace bakelight::packing
