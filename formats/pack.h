// The pack: one binary glTF 2.0 (.glb). Mesh and base colour are plain glTF, so that any glTF viewer opens it
// as an ordinary model; radiance transfer lives in the vendor extension BAKELIGHT_radiance_transfer
// (docs/FORMATS.md and docs/schema/BAKELIGHT_radiance_transfer.schema.json). All released versions stay
// readable.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/file.h"
#include "formats/pack_contents.h"

namespace bakelight::formats {

inline constexpr int kPackVersion = 3;

struct PackOptions {
  bool draco = false;     // KHR_draco_mesh_compression; the tables are permuted so as to stay in step
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
// Tables of the pack point into the file, which stays mapped with them: opening takes the mesh's memory, and
// that of tables as they are read.
Pack readPack(const std::filesystem::path& path);

// What lies where, for inspect and the docs.
struct PackSection {
  std::string name;  // "indices", "positions", "transfer", "matrices": docs/FORMATS.md lists them
  std::uint64_t offset_bytes, size_bytes;
  std::string checksum;
};
std::vector<PackSection> packSections(std::span<const std::byte> bytes, const std::string& file);
// The version that the file has; at most kPackVersion.
int packVersion(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::formats
