// What the writer and the readers of packs must agree on. Private to formats/pack*.cpp.
#pragma once

#include <string>
#include <vector>

#include "formats/glb.h"
#include "formats/pack.h"

namespace bakelight::formats {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

// glTF's number of each type of component in use.
enum ComponentType { kUint32Component = 5125, kFloat32Component = 5126 };

// glTF counts v from the top of an image, a TriangleMesh from the bottom. Its own inverse up to rounding, and
// exact in float for the multiples of 2^-24 in [0, 1].
std::vector<Float2> flippedTexcoords(const std::vector<Float2>& texcoords);

// `pack` must have passed checkPack.
Bytes encodeCheckedPack(const Pack& pack, const PackOptions& options, const std::string& file);
// What the file says, not yet judged by checkPack: version 3, and 1 or 2.
Pack decodeUncheckedPack(const GlbReader& glb);
Pack decodeUncheckedPack2(const GlbReader& glb);

}  // namespace bakelight::formats
