// Meshes from elsewhere: OBJ, PLY, STL, OFF and glTF by readers of our own; 3DS, DAE, FBX and whatever else
// assimp reads by assimp. docs/FORMATS.md says what is read of each.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/file.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// A picture that gives a material its albedo.
struct AlbedoTexture {
  // How coordinates outside 0–1 are read, as glTF's samplers say.
  enum class Wrap { kRepeat, kMirror, kClamp };

  std::string name;            // for messages: the path, or where in which file it is embedded
  std::filesystem::path path;  // a picture file; empty if the picture is embedded
  Bytes bytes = {};            // what an embedded picture's file would hold (PNG, JPEG, …)
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  bool as_stored = false;  // not turned as the picture's Exif data say: glTF
};

struct MeshImport {
  // Its colours are the vertex colours times the material's own colour (OBJ: Kd, glTF: baseColorFactor) and
  // are to be multiplied by the material's texture, if it has one. No colours, where neither says anything.
  TriangleMesh mesh;
  std::vector<AlbedoTexture> textures = {};
  // For each of mesh.material_names the index of its texture, or −1. Empty without textures.
  std::vector<int> material_textures = {};
  // Where textures are looked up: one a vertex, origin at the lower left, the material's own set of
  // coordinates with its transform applied. Vertices without a texture have {0, 0}. Empty without textures.
  std::vector<Float2> texture_lookups = {};
  // What a person should know: "12 polygons were triangulated", "3 materials were merged".
  std::vector<std::string> notes = {};
};

// +Y up, where the file says what is up, or its format does; OBJ, PLY, STL and OFF do not say and are left as
// they are. Coordinates are the floats nearest to what those files and glTF say.
//
// Colours become linear ones in 0–1. glTF's are linear already, and so are Kd of MTL files, and PLY's unless
// they have 8 bits ("uchar red"); those are sRGB by custom, as are OBJ's ("v x y z r g b"), OFF's and STL's.
// What lies outside 0–1 is clamped, and noted; vertices without a colour among others that have one are
// white, and noted.
//
// All meshes of the file in one, each node's transform applied, polygons triangulated, points and lines left
// out. Vertices that no face uses are left out, and noted. Others are not welded and nothing is repaired:
// that is the simplify stage's work, which counts it. Throws Error(kBadInput) naming file and element:
// unreadable, truncated, no triangle, an index out of range, a coordinate that is not finite (with its
// vertex).
MeshImport importMesh(const std::filesystem::path& path);

// The endings (lowercase, with the dot) that importMesh takes for a mesh file; used to find assets in
// folders.
const std::vector<std::string>& meshFileEndings();

}  // namespace bakelight::formats
