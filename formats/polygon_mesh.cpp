#include "formats/polygon_mesh.h"

#include <bit>
#include <cmath>

#include "formats/mesh_corners.h"

namespace bakelight::formats {
namespace {

std::uint32_t bitsOf(float value) {
  return std::bit_cast<std::uint32_t>(value);
}

Float3 whiteIfNone(const CornerTable::Corner& bits) {
  const Float3 color = {std::bit_cast<float>(bits[0]), std::bit_cast<float>(bits[1]),
                        std::bit_cast<float>(bits[2])};
  return std::isnan(color[0]) ? Float3{1, 1, 1} : color;
}

void noteWhiteFaces(const PolygonMesh& mesh, std::vector<std::string>& notes) {
  std::size_t without = 0;
  for (const Float3& color : mesh.face_colors) without += std::isnan(color[0]);
  if (without > 0)
    notes.push_back(counted(without, "face has no colour, and was taken as white",
                            "faces have no colour, and were taken as white"));
}

// One for each combination that a corner has.
void makeVerticesOfCorners(const PolygonMesh& mesh, const std::vector<std::uint32_t>& triangle_faces,
                           MeshPart& part) {
  CornerTable table, colors;
  std::vector<std::uint32_t> face_color;
  for (const Float3& c : mesh.face_colors)
    face_color.push_back(colors.numberOf({bitsOf(c[0]), bitsOf(c[1]), bitsOf(c[2]), 0}));
  for (std::size_t t = 0; t < part.triangles.size(); ++t)
    for (std::uint32_t& corner : part.triangles[t]) {
      const Float2 uv = mesh.corner_texcoords.empty() ? Float2{0, 0} : mesh.corner_texcoords[corner];
      corner = table.numberOf({mesh.corners[corner], bitsOf(uv[0]), bitsOf(uv[1]),
                               face_color.empty() ? 0 : face_color[triangle_faces[t]]});
    }
  for (const auto& [vertex, u, v, color] : table.corners()) {
    part.positions.push_back(mesh.positions[vertex]);
    if (!mesh.normals.empty()) part.normals.push_back(mesh.normals[vertex]);
    if (!mesh.corner_texcoords.empty())
      part.texcoords.push_back({std::bit_cast<float>(u), std::bit_cast<float>(v)});
    else if (!mesh.texcoords.empty())
      part.texcoords.push_back(mesh.texcoords[vertex]);
    if (!mesh.colors.empty())
      part.colors.push_back(mesh.colors[vertex]);
    else if (!mesh.face_colors.empty())
      part.colors.push_back(whiteIfNone(colors.corners()[color]));
  }
}

void takeVertices(PolygonMesh& mesh, MeshPart& part) {
  for (Triangle& triangle : part.triangles)
    for (std::uint32_t& corner : triangle) corner = mesh.corners[corner];
  part.positions = std::move(mesh.positions);
  part.normals = std::move(mesh.normals);
  part.texcoords = std::move(mesh.texcoords);
  part.colors = std::move(mesh.colors);
}

}  // namespace

std::string counted(std::size_t count, const std::string& one, const std::string& several) {
  return std::to_string(count) + " " + (count == 1 ? one : several);
}

MeshPart partOf(PolygonMesh mesh, std::vector<std::string>& notes) {
  if (!mesh.colors.empty() && !mesh.face_colors.empty()) {
    notes.push_back("colours of faces were left out, as vertices have colours too");
    mesh.face_colors.clear();
  }
  noteWhiteFaces(mesh, notes);
  const std::size_t vertex_count = mesh.positions.size();
  std::vector<bool> used(vertex_count);
  std::size_t unused = vertex_count;
  for (const std::uint32_t vertex : mesh.corners) {
    unused -= !used[vertex];
    used[vertex] = true;
  }
  if (unused > 0)
    notes.push_back(std::to_string(unused) + " of " + std::to_string(vertex_count) +
                    " vertices belong to no face, and were left out");

  MeshPart part;
  FaceTriangles faces = triangulateFaces(
      mesh.corner_counts, [&](std::uint32_t corner) { return mesh.positions[mesh.corners[corner]]; }, notes);
  part.triangles = std::move(faces.triangles);
  if (!mesh.face_materials.empty())
    for (const std::uint32_t face : faces.faces) part.triangle_materials.push_back(mesh.face_materials[face]);
  if (mesh.corner_texcoords.empty() && mesh.face_colors.empty())
    takeVertices(mesh, part);
  else
    makeVerticesOfCorners(mesh, faces.faces, part);
  keepUsedVertices(part);
  return part;
}

}  // namespace bakelight::formats
