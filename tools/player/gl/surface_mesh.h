// Triangles on the GPU, and how those whose vertices have a radiance each are drawn.
#pragma once

#include <cstddef>
#include <Eigen/Core>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/player/gl/gl_objects.h"
#include "transport/vector_types.h"

namespace bakelight::player {

// The triangles of a pack. Positions go to the GPU from `origin`: an object far from the world's origin keeps
// its float digits.
class SurfaceMesh {
 public:
  // Throws Error(kBadInput) for more triangles than one draw call takes.
  SurfaceMesh(const formats::TriangleMesh& mesh, const transport::Vec3& origin);

  const transport::Vec3& origin() const { return origin_; }
  std::size_t vertexCount() const { return vertex_count_; }
  GLsizei indexCount() const { return index_count_; }
  const Buffer& positions() const { return positions_; }  // n × XYZ float32, from the origin
  const Buffer& indices() const { return indices_; }      // three uint32 a triangle
  std::size_t gpuBytes() const { return sizeInBytes(positions_) + sizeInBytes(indices_); }

 private:
  transport::Vec3 origin_;
  std::size_t vertex_count_;
  GLsizei index_count_;
  Buffer positions_, indices_;
};

// Indices of that many triangles. Throws Error(kBadInput) naming `element` if there are too many for one draw
// call; `remedy` is what to do then.
GLsizei indexCountOf(std::size_t triangles, const char* element, const char* remedy);

// Three floats a vertex at a location of the vertex shader.
struct VertexAttribute {
  GLuint location;
  const Buffer* buffer;
};
// Buffers must outlive it.
VertexArray makeVertexArray(const Buffer& indices, const std::vector<VertexAttribute>& attributes);

// Radiance a vertex, interpolated over the triangles.
class RadiantSurface {
 public:
  // `radiance`: n × RGB float32. Buffers must outlive it.
  RadiantSurface(const Buffer& positions, const Buffer& radiance, const Buffer& indices, GLsizei index_count);

  // Into the framebuffer that is bound.
  void draw(const Eigen::Matrix4f& clip_from_position) const;

 private:
  Program program_;
  VertexArray vertices_;
  GLsizei index_count_;
};

}  // namespace bakelight::player
