// OpenGL names that delete themselves. Each needs a current 4.5 core context when made, used and destroyed.
#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <utility>

namespace bakelight::player {

// Owns one name; Traits::destroy gives it back. 0 owns nothing.
template <class Traits>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GLuint name) : name_(name) {}
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlObject() {
    if (name_ != 0) Traits::destroy(name_);
  }

  GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
};

struct BufferTraits {
  static void destroy(GLuint name) { glDeleteBuffers(1, &name); }
};
struct TextureTraits {
  static void destroy(GLuint name) { glDeleteTextures(1, &name); }
};
struct FramebufferTraits {
  static void destroy(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct VertexArrayTraits {
  static void destroy(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct ProgramTraits {
  static void destroy(GLuint name) { glDeleteProgram(name); }
};
struct ShaderTraits {
  static void destroy(GLuint name) { glDeleteShader(name); }
};

struct QueryTraits {
  static void destroy(GLuint name) { glDeleteQueries(1, &name); }
};

using Buffer = GlObject<BufferTraits>;
using Texture = GlObject<TextureTraits>;
using Framebuffer = GlObject<FramebufferTraits>;
using VertexArray = GlObject<VertexArrayTraits>;
using Program = GlObject<ProgramTraits>;
using Shader = GlObject<ShaderTraits>;
using Query = GlObject<QueryTraits>;

// Immutable storage of `size_bytes`, filled from `data` unless that is null. A size of 0 gets 4 bytes, as GL
// knows no empty storage. `flags` as for glNamedBufferStorage.
Buffer makeBuffer(std::size_t size_bytes, const void* data, GLbitfield flags = 0);
// Bytes of a buffer's storage; 0 for one that owns nothing.
std::size_t sizeInBytes(const Buffer& buffer);
// One level, no filtering, clamped to the edge. `format` is sized: GL_RGBA32F.
Texture makeTexture(GLenum format, int width_px, int height_px);
// For texelFetch: many drivers read so what shaders scatter faster than as shader storage. `buffer` must outlive it.
Texture makeBufferTexture(GLenum format, const Buffer& buffer);
// Throws Error(kNotAvailable) if GL calls the combination incomplete. `depth` may own nothing.
Framebuffer makeFramebuffer(const Texture& color, const Texture& depth);
// The same with one layer of an array texture.
Framebuffer makeLayerFramebuffer(const Texture& color_layers, int layer, const Texture& depth);
VertexArray makeVertexArray();
Query makeQuery(GLenum target);

}  // namespace bakelight::player
