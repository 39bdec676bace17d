// What the readers of single formats deliver, and how it becomes one mesh. Private to the importers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/mesh_import.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

struct PartMaterial {
  std::string name;
  std::optional<Float3> color;  // linear, as the file has it; none: the file does not say
  int texture = -1;             // index into the textures, or −1
};

// A primitive of a file, its node's transform applied. Lists of attributes are empty, or have one entry a
// vertex.
struct MeshPart {
  std::vector<Float3> positions;
  std::vector<Float3> normals;    // of any length
  std::vector<Float2> texcoords;  // the mesh's first set, origin at the lower left
  // Where the material's texture is looked up, if elsewhere: another set, or moved by a texture transform.
  std::vector<Float2> texture_lookups;
  std::vector<Float3> colors;  // of the vertices, linear, as the file has them
  std::vector<Triangle> triangles;
  int material = -1;                    // of all triangles: an index into the materials, or −1 for none
  std::vector<int> triangle_materials;  // of each triangle, where they differ; else empty
};

struct MeshParts {
  std::vector<MeshPart> parts;
  std::vector<PartMaterial> materials;  // all that the file names, in its order
  std::vector<AlbedoTexture> textures;
  std::vector<std::string> notes;
};

// One mesh of all parts that have triangles, in order; indices are in range (the readers have checked them).
//
// A vertex whose triangles have different materials is copied, so that each material's colour ends at its
// border: the first material keeps the vertex, copies follow the part's vertices. Colours are the vertex
// colours times the material's colour, each white where missing (noted, where no texture explains it); values
// outside 0–1 are clamped, and noted; there are none if neither colours nor colours of the materials in use
// are given anywhere. Normals, texture coordinates and vertex colours that are not usable (no direction, not
// finite), and normals and texture coordinates that not every vertex has, are left out, and noted. Triangles
// without a material get a nameless one if others have one. Textures that no triangle uses are left out.
// Throws Error(kBadInput) naming `file` if there is no triangle, for more than 2³² vertices, and for a
// texture without coordinates to look it up. Cost: linear.
MeshImport merged(MeshParts parts, const std::string& file);

}  // namespace bakelight::formats
