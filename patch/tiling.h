// The geometry of a patch, again and again over a surface: what bi-scale shading approximates, as triangles.
#pragma once

#include <cstddef>
#include <string>

#include "formats/triangle_mesh.h"
#include "patch/patch_geometry.h"

namespace bakelight::patch {

// How a patch lies on a surface with texture coordinates (u, v): its place there is (u, v) · `repeats`, in its widths.
struct Tiling {
  double repeats = 1;
  double width = 1;  // of the patch on the surface, in the surface's unit: what heights are multiplied by
};
// By a patch of about this width, as packs have it (transport::patchRepeats).
Tiling tilingOf(const formats::TriangleMesh& surface, double width);

struct TiledSurface {
  // Shell mapping: a point (x, y, z) of the patch goes to S(x, y) + z · width · N(x, y), S and N the surface's
  // position and unit interpolated normal. Triangles are cut along those of the surface, each within one of them.
  // `normals` are the patch's, turned; `texcoords` the places in the patch, in widths, not wrapped; `colors` its
  // albedo times its mesh's colors: PatchGeometry::textureAt of the texcoords times these is the albedo.
  formats::TriangleMesh mesh;
  // Edges of the surface at which two charts meet that do not continue each other's patch; it is cut there, as it is
  // at the surface's border.
  std::size_t broken_edges = 0;
  // Triangles of the surface that have no area, in space or as texture: bare.
  std::size_t bare_triangles = 0;
};

inline constexpr std::size_t kMostTiledTriangles = 50'000'000;

// `surface` has normals and texture coordinates; charts may be mirrored. Heights are not scaled where texture
// coordinates are stretched. Throws Error(kBadInput) naming `file`, the surface's: no texture coordinates or normals,
// about kMostTiledTriangles and more.
TiledSurface tiled(const PatchGeometry& patch, const formats::TriangleMesh& surface, const Tiling& tiling,
                   const std::string& file);

}  // namespace bakelight::patch
