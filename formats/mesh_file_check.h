// What assimp lets pass, or worse: a file that was cut short. assimp 5.2 turns a cut index into another one,
// drops a cut line, fills missing faces with nothing, fails an assertion on an OFF and never returns from a
// cut PLY. So the formats it is careless with are looked through first. Private to formats/mesh_import.cpp.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace bakelight::formats {

// Throws Error(kBadInput) naming `file` and its line or element if the file is malformed or cut short, judged
// by its ending:
//   .obj  malformed v, vt, vn and f lines, indices out of range, and a last line without newline where
//   vertices are left unused .ply  a header or body that ends too early      .off  fewer numbers than the
//   header says .stl  (ascii) no endsolid
// Returns notes about what is suspicious and legal. Other formats are left to assimp. Cost: one pass.
std::vector<std::string> checkMeshFile(const std::filesystem::path& path, std::span<const std::byte> bytes);

}  // namespace bakelight::formats
