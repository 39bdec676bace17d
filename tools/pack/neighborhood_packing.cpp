#include "tools/pack/neighborhood_packing.h"

#include <cmath>
#include <utility>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/part_tensors.h"

namespace bakelight::packing {
namespace {

// Brings a table to `precision`; the relative error that this makes.
double encode(formats::EncodedTable& table, formats::Precision precision, const std::string& file,
              const char* name) {
  const std::vector<float> baked = table.decode();
  table = formats::encodeTable(baked, table.columns, precision, file, name);
  const std::vector<float> stored = table.decode();
  double squares = 0, differences = 0;
  for (std::size_t i = 0; i < baked.size(); ++i) {
    const double value = baked[i], difference = static_cast<double>(stored[i]) - value;
    squares += value * value;
    differences += difference * difference;
  }
  return squares > 0 ? std::sqrt(differences / squares) : 0;
}

}  // namespace

PackedNeighborhood readNeighborhood(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                                    const std::string& mesh_file, formats::Precision precision) {
  const std::string file = path.string();
  const formats::TensorFile tensors = formats::readSafetensors(path);
  if (tensors.requireMetadata("mesh_hash", file) != formats::geometryHash(mesh))
    throw badInput({file, "metadata mesh_hash", ""}, "it was baked for another mesh than " + mesh_file,
                   formats::geometryHash(mesh), "bake the neighborhood again, for this mesh");
  formats::PackPart part{formats::Neighborhood()};
  formats::readPart(part, tensors, file);
  PackedNeighborhood result{std::move(*part.as<formats::Neighborhood>()), {}};
  if (result.part.ground)
    result.errors["ground"] = encode(result.part.ground->vectors, precision, file, "groundVectors");
  if (result.part.volume)
    result.errors["volume"] = encode(result.part.volume->matrices, precision, file, "volumeMatrices");
  return result;
}

}  // namespace bakelight::packing
