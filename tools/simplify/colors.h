// Albedo carried from the original surface to the simplified one: from a texture or from vertex colours.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"

namespace bakelight::simplify {

// An albedo texture as linear R, G, B: 8-bit formats hold display codes (sRGB), .exr and .hdr are linear.
// Throws Error(kBadInput) if it has neither R, G, B nor a single channel.
formats::Image readAlbedoTexture(const std::filesystem::path& path);

// Linear albedo at the vertices of `simplified`, 0–1: the mean over the triangles around each, weighted by
// its hat function, of the colour at the closest point of `source`; so the texture is filtered down to the
// vertices' density. From `texture` (bilinear, repeating) if given, else from the source's vertex colours;
// empty if there is neither. Throws Error(kBadInput) naming `file` if there is a texture but no texture
// coordinates. Deterministic. About 30 µs a triangle.
std::vector<formats::Float3> carryAlbedo(const formats::TriangleMesh& source, const formats::Image* texture,
                                         const formats::TriangleMesh& simplified, const std::string& file);

}  // namespace bakelight::simplify
