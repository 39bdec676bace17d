// What an OBJ file states, line by line, before its corners become vertices. Private to formats/mesh_obj.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Numbers from 1 as in the file, with those counted back resolved; 0: the corner has none.
struct ObjCorner {
  std::uint32_t vertex = 0, texcoord = 0, normal = 0;
};

struct ObjStatements {
  std::vector<Float3> positions;
  std::vector<Float3> colors;  // as the file has them; NaN where a vertex has none. Empty if none has
  std::vector<Float2> texcoords;
  std::vector<Float3> normals;
  std::vector<ObjCorner> corners;            // of all faces, one after the other
  std::vector<std::uint32_t> corner_counts;  // of each face, at least 3
  std::vector<int> face_materials;           // of each face, an index into `materials` or −1
  std::vector<std::string> materials;        // names in `usemtl`, in order of first naming

  struct Library {
    std::string names;  // the rest of a line `mtllib`
    std::uint64_t line = 0;
  };
  std::vector<Library> libraries;

  struct NotFinite {
    std::size_t vertex;  // from 0
    std::uint64_t line;
  };
  std::vector<NotFinite> not_finite;  // positions

  std::vector<std::string> notes;
  bool ends_inside_line = false;  // the last line has no line end
  std::uint64_t line_count = 0;
};

// Every index is checked. Throws Error(kBadInput) naming `file` and the line.
ObjStatements readObjStatements(std::string_view text, const std::string& file);

// Only the lines `mtllib`.
std::vector<ObjStatements::Library> objLibraries(std::string_view text);

}  // namespace bakelight::formats
