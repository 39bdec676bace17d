// A patch of meso-structure as a surface: what rtt renders, and what stands on a plane that is tiled with it.
#pragma once

#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/material.h"
#include "formats/triangle_mesh.h"

namespace bakelight::patch {

using formats::Float3;

// Lengths are in widths of the patch: it reaches from 0 to 1 along x, to the right, and from 0 to `aspect` along
// y, upwards; z points out of it, and z = 0 is midway between its lowest and its highest point.
struct PatchGeometry {
  // One period of the surface, each part at any multiple of the periods. Normals are unit and never missing;
  // where two triangles meet at a crease each has vertices of its own. `colors` multiply `albedo`.
  formats::TriangleMesh mesh;
  double aspect = 1;
  // The surface repeats so; 1 and aspect, or twice that: a patch that does not continue itself is continued by
  // its mirror images.
  double period_x = 1, period_y = 1;
  Float3 albedo = {1, 1, 1};    // linear, 0–1, times the texture and the mesh's colors
  formats::Image texture = {};  // R, G, B, linear, over the patch; no texels: none
  formats::Reflection reflection = {};
  std::vector<std::string> notes = {};  // what a user should know, each naming the file

  bool mirrored() const { return period_x > 1; }
  // At barycentric weights u and v of the triangle's second and third vertex.
  Float3 albedoAt(std::uint32_t triangle, float u, float v) const;
  Float3 albedoOfVertex(std::uint32_t vertex) const;
  Float3 textureAt(double x, double y) const;  // bilinear; white without a texture
};

}  // namespace bakelight::patch
