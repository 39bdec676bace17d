// What a PLY file states, before its faces become triangles. Private to formats/ply_parts.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/ply_header.h"
#include "formats/polygon_mesh.h"

namespace bakelight::formats {

struct PlyContents {
  // Colours are the numbers of the file, materials those of `texnumber`; faces of triangle strips stand at
  // the end.
  PolygonMesh mesh;
  PlyScalar color_type = PlyScalar::kFloat32, face_color_type = PlyScalar::kFloat32;

  struct NotFinite {
    std::uint64_t vertex;
    std::uint64_t line;  // 0: not a text
  };
  std::vector<NotFinite> not_finite;  // positions
  std::vector<std::string> notes;
};

// Throws Error(kBadInput) naming `file` and the element.
PlyContents readPlyContents(const PlyHeader& header, std::span<const std::byte> bytes,
                            const std::string& file);

}  // namespace bakelight::formats
