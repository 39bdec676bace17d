#include "tools/player/gl/gl_objects.h"

#include <algorithm>
#include <string>

#include "formats/error.h"

namespace bakelight::player {
namespace {

void requireComplete(const Framebuffer& framebuffer) {
  const GLenum status = glCheckNamedFramebufferStatus(framebuffer.name(), GL_DRAW_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw Error(ExitStatus::kNotAvailable, {"", "framebuffer", ""},
                "this OpenGL cannot draw into the picture's format (status " + std::to_string(status) + ")",
                "32-bit float colour and depth", "a smaller picture, or another driver");
}

}  // namespace

Buffer makeBuffer(std::size_t size_bytes, const void* data, GLbitfield flags) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  Buffer buffer(name);
  const bool empty = size_bytes == 0;
  glNamedBufferStorage(name, empty ? 4 : static_cast<GLsizeiptr>(size_bytes), empty ? nullptr : data, flags);
  return buffer;
}

std::size_t sizeInBytes(const Buffer& buffer) {
  GLint64 size_bytes = 0;
  if (buffer.name() != 0) glGetNamedBufferParameteri64v(buffer.name(), GL_BUFFER_SIZE, &size_bytes);
  return static_cast<std::size_t>(size_bytes);
}

Texture makeTexture(GLenum format, int width_px, int height_px) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  Texture texture(name);
  glTextureStorage2D(name, 1, format, width_px, height_px);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

Texture makeBufferTexture(GLenum format, const Buffer& buffer) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &name);
  glTextureBuffer(name, format, buffer.name());
  return Texture(name);
}

Framebuffer makeFramebuffer(const Texture& color, const Texture& depth) {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  Framebuffer framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, color.name(), 0);
  if (depth.name() != 0) glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth.name(), 0);
  requireComplete(framebuffer);
  return framebuffer;
}

Framebuffer makeLayerFramebuffer(const Texture& color_layers, int layer, const Texture& depth) {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  Framebuffer framebuffer(name);
  glNamedFramebufferTextureLayer(name, GL_COLOR_ATTACHMENT0, color_layers.name(), 0, layer);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth.name(), 0);
  requireComplete(framebuffer);
  return framebuffer;
}

VertexArray makeVertexArray() {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  return VertexArray(name);
}

Query makeQuery(GLenum target) {
  GLuint name = 0;
  glCreateQueries(target, 1, &name);
  return Query(name);
}

}  // namespace bakelight::player
