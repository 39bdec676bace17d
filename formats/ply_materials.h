// How a PLY names the materials of its faces. Private to the readers and the writer of PLY.
//
//   comment material 0 red%20paint
//   comment material 1
//   …
//   property uint material_index
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace bakelight::formats {

// The face property, an index into the names.
inline constexpr const char* kPlyMaterialIndex = "material_index";

// The comment, without that word, that names a material. Bytes other than visible ASCII, and %, are written
// as in a URI (RFC 3986, section 2.1), so any name survives.
std::string plyMaterialComment(std::size_t index, const std::string& name);

// The names told by a header's comments; none unless they count up from 0.
std::vector<std::string> plyMaterialNames(const std::vector<std::string>& comments);

}  // namespace bakelight::formats
