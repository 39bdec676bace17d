#include "tools/player/gl/surface_mesh.h"

#include <limits>
#include <string>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"

namespace bakelight::player {
namespace {

enum Attribute : GLuint { kPosition = 0, kRadiance = 1 };  // locations in surface.vert

Buffer positionsFrom(const transport::Vec3& origin, const formats::TriangleMesh& mesh) {
  std::vector<formats::Float3> positions;
  positions.reserve(mesh.positions.size());
  for (const auto& position : mesh.positions)
    positions.push_back(transport::float3(transport::vec3(position) - origin));
  return makeBuffer(positions.size() * sizeof(formats::Float3), positions.data());
}

}  // namespace

GLsizei indexCountOf(std::size_t triangles, const char* element, const char* remedy) {
  constexpr std::size_t kMost = static_cast<std::size_t>(std::numeric_limits<GLsizei>::max()) / 3;
  if (triangles > kMost)
    throw badInput({"", element, ""}, std::to_string(triangles) + " triangles are too many for one draw call",
                   "at most " + std::to_string(kMost) + " triangles", remedy);
  return static_cast<GLsizei>(3 * triangles);
}

SurfaceMesh::SurfaceMesh(const formats::TriangleMesh& mesh, const transport::Vec3& origin)
    : origin_(origin),
      vertex_count_(mesh.vertexCount()),
      index_count_(indexCountOf(mesh.triangleCount(), "mesh", "a simplified mesh")),
      positions_(positionsFrom(origin, mesh)),
      indices_(makeBuffer(mesh.triangles.size() * sizeof(formats::Triangle), mesh.triangles.data())) {
  throwIfGlFailed("uploading the mesh");
}

VertexArray makeVertexArray(const Buffer& indices, const std::vector<VertexAttribute>& attributes) {
  VertexArray vertices = makeVertexArray();
  const GLuint name = vertices.name();
  for (const VertexAttribute& attribute : attributes) {
    glVertexArrayVertexBuffer(name, attribute.location, attribute.buffer->name(), 0, sizeof(formats::Float3));
    glEnableVertexArrayAttrib(name, attribute.location);
    glVertexArrayAttribFormat(name, attribute.location, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(name, attribute.location, attribute.location);
  }
  glVertexArrayElementBuffer(name, indices.name());
  return vertices;
}

RadiantSurface::RadiantSurface(const Buffer& positions, const Buffer& radiance, const Buffer& indices,
                               GLsizei index_count)
    : program_(makeProgram({{GL_VERTEX_SHADER, {kSurfaceVert}}, {GL_FRAGMENT_SHADER, {kSurfaceFrag}}})),
      vertices_(makeVertexArray(indices, {{kPosition, &positions}, {kRadiance, &radiance}})),
      index_count_(index_count) {}

void RadiantSurface::draw(const Eigen::Matrix4f& clip_from_position) const {
  glUseProgram(program_.name());
  glUniformMatrix4fv(0, 1, GL_FALSE, clip_from_position.data());
  glBindVertexArray(vertices_.name());
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
}

}  // namespace bakelight::player
