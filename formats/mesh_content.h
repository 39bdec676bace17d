// What a file's first bytes say it is, so that a file under a wrong name, or something in a file's place, is
// told as such. Private to formats/mesh_import.cpp.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace bakelight::formats {

// `ending` as lowerEnding gives it. Throws Error(kBadInput) naming `file` if it is empty, a pointer of Git
// LFS, a web page or an archive, or a mesh file of another ending.
void checkMeshContent(std::span<const std::byte> bytes, const std::string& ending, const std::string& file);

}  // namespace bakelight::formats
