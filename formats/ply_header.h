// The header of a PLY file. Private to formats/mesh_ply.cpp and formats/ply_parts.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bakelight::formats {

enum class PlyScalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

std::size_t sizeOf(PlyScalar type);  // bytes
bool isInteger(PlyScalar type);
// Little-endian; integer types only.
std::int64_t plyIntegerAt(const std::byte* data, PlyScalar type);

struct PlyProperty {
  std::string name;
  std::optional<PlyScalar> list_count;  // of a list property
  PlyScalar type;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  std::string format, version;  // "ascii", "binary_little_endian", "binary_big_endian"; "1.0"
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;       // each without the word itself
  std::vector<std::string> unknown_lines;  // begin with no keyword of PLY, as some exporters write their name
  std::size_t size_bytes = 0;              // where the body begins
  std::uint64_t line_count = 0;            // up to there
};

// Lines may end in LF, CR LF or CR, the same in the whole header. Throws Error(kBadInput) naming `file` and
// the malformed line.
PlyHeader readPlyHeader(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::formats
