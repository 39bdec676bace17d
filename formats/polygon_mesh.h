// Meshes of polygons whose corners share the indices of vertices, as PLY and OFF have them. Private to the
// importers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/mesh_parts.h"
#include "formats/polygon.h"

namespace bakelight::formats {

struct PolygonMesh {
  // Of vertices: empty, or one each.
  std::vector<Float3> positions, normals, colors;
  std::vector<Float2> texcoords;
  // Of faces: at least 3 corners each, vertices that exist.
  std::vector<std::uint32_t> corners, corner_counts;
  std::vector<Float2> corner_texcoords;  // empty, or one a corner; NaN for those without. Go before texcoords
  std::vector<Float3> face_colors;       // empty, or one a face; NaN for those without. Go after colors
  std::vector<int> face_materials;       // empty, or one a face; −1 for those without
};

// Faces become triangles, vertices are copied where their corners differ, and those of no face are left out.
// Adds notes about what a person should know.
MeshPart partOf(PolygonMesh mesh, std::vector<std::string>& notes);

struct FaceTriangles {
  std::vector<Triangle> triangles;   // corners, counted over all faces
  std::vector<std::uint32_t> faces;  // of each triangle
};

// `position` gives the position of a corner.
template <class CornerPosition>
FaceTriangles triangulateFaces(std::span<const std::uint32_t> corner_counts, const CornerPosition& position,
                               std::vector<std::string>& notes);

// "3 faces have"
std::string counted(std::size_t count, const std::string& one, const std::string& several);

// ---

template <class CornerPosition>
FaceTriangles triangulateFaces(std::span<const std::uint32_t> corner_counts, const CornerPosition& position,
                               std::vector<std::string>& notes) {
  FaceTriangles result;
  PolygonTriangulator triangulator;
  std::vector<Float3> positions;
  std::vector<Triangle> triangles;
  std::uint32_t begin = 0;
  std::size_t doubtful = 0;
  result.triangles.reserve(corner_counts.size());
  result.faces.reserve(corner_counts.size());
  for (std::size_t face = 0; face < corner_counts.size(); ++face) {
    triangles.clear();
    positions.clear();
    for (std::uint32_t k = 0; k < corner_counts[face]; ++k) positions.push_back(position(begin + k));
    doubtful += !triangulator.triangulate(positions, triangles);
    for (const Triangle& t : triangles) {
      result.triangles.push_back({begin + t[0], begin + t[1], begin + t[2]});
      result.faces.push_back(static_cast<std::uint32_t>(face));
    }
    begin += corner_counts[face];
  }
  if (doubtful > 0)
    notes.push_back(counted(doubtful, "polygon has no area or crosses itself; its triangles are a guess",
                            "polygons have no area or cross themselves; their triangles are a guess"));
  return result;
}

}  // namespace bakelight::formats
