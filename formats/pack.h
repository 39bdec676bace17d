// The pack: one binary glTF 2.0 (.glb). Mesh and base colour are plain glTF, so that any glTF viewer opens it
// as an ordinary model; radiance transfer lives in the vendor extension BAKELIGHT_radiance_transfer
// (docs/FORMATS.md and docs/schema/BAKELIGHT_radiance_transfer.schema.json). All released versions stay
// readable.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/file.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

inline constexpr int kPackVersion = 1;

// Diffuse transfer vectors (Sloan et al. 2002, eq. 10): n vertices × order² floats, row-major, SH index
// l(l+1)+m. Exit radiance of a vertex = base colour × Σ_i vectors[i] · light[i]: 1/π is inside, the albedo is
// not.
struct DiffuseTransfer {
  int order = 0;           // bands, 1–10
  std::string visibility;  // "unshadowed" or "shadowed"
  std::vector<float> vectors;
};

struct Pack {
  std::string name;               // of the asset
  TriangleMesh mesh;              // with normals
  Float3 base_color = {1, 1, 1};  // diffuse albedo, linear, 0–1
  DiffuseTransfer transfer;
};

struct PackOptions {
  bool draco = false;     // KHR_draco_mesh_compression; the transfer table is permuted so as to stay in step
  int position_bits = 0;  // quantisation of Draco positions, 8–30; 0: none (lossless)
  int normal_bits = 0;    // likewise, 6–30
};

// Throws Error(kBadInput) naming `file` for what cannot be a pack: no vertex, tables of unequal length,
// values not finite, more than 4 GiB.
Bytes encodePack(const Pack& pack, const PackOptions& options, const std::string& file);

// Throws Error(kBadInput) naming file and section: not a GLB, wrong version, truncated, checksum of a section
// wrong, offsets or sizes out of range, no BAKELIGHT_radiance_transfer extension.
Pack decodePack(std::span<const std::byte> bytes, const std::string& file);

void writePack(const std::filesystem::path& path, const Pack& pack, const PackOptions& options);  // atomic
Pack readPack(const std::filesystem::path& path);

// What lies where, for inspect and the docs.
struct PackSection {
  std::string name;  // "indices", "positions", "normals", "transfer", "draco"
  std::uint64_t offset_bytes, size_bytes;
  std::string checksum;
};
std::vector<PackSection> packSections(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::formats
