// The neighborhood stage's file as a part of a pack.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "formats/neighborhood.h"
#include "formats/pack_contents.h"

namespace bakelight::packing {

struct PackedNeighborhood {
  formats::Neighborhood part;
  // Of "ground" and "volume": √(Σ(stored − baked)² / Σ baked²).
  std::map<std::string, double> errors;
};
// Throws Error(kBadInput) naming file and tensor or key, also if it was baked for another mesh.
PackedNeighborhood readNeighborhood(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                                    const std::string& mesh_file, formats::Precision precision);

}  // namespace bakelight::packing
