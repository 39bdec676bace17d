#include "tools/player/picture_target.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "tools/player/gl_context.h"
#include "tools/player/gl_program.h"

namespace bakelight::player {
namespace {

void requireSize(int width_px, int height_px, int supersampling) {
  GLint largest = 0;
  std::array<GLint, 2> largest_viewport{};
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, largest_viewport.data());
  largest = std::min({largest, largest_viewport[0], largest_viewport[1]});
  if (std::max(width_px, height_px) * static_cast<std::int64_t>(supersampling) <= largest) return;
  throw badInput({"", "picture size", ""},
                 std::to_string(width_px) + " × " + std::to_string(height_px) + " pixels with " +
                     std::to_string(supersampling) + " subsamples an axis are too many for this OpenGL",
                 "at most " + std::to_string(largest) + " subsamples along an axis",
                 "a smaller width, height or supersampling");
}

// GL's rows go from bottom to top.
template <class Value>
void flipRows(std::vector<Value>& values, int width_px, int height_px) {
  const std::size_t row = static_cast<std::size_t>(width_px) * 4;
  for (int y = 0; y < height_px / 2; ++y)
    std::swap_ranges(values.begin() + y * row, values.begin() + (y + 1) * row,
                     values.begin() + (height_px - 1 - y) * row);
}

}  // namespace

PictureTarget::PictureTarget()
    : resolve_program_(
          makeProgram({{GL_VERTEX_SHADER, {kFullscreenVert}}, {GL_FRAGMENT_SHADER, {kResolveFrag}}})),
      no_attributes_(makeVertexArray()) {}

void PictureTarget::resize(int width_px, int height_px, int supersampling) {
  if (width_px == width_px_ && height_px == height_px_ && supersampling == supersampling_) return;
  requireSize(width_px, height_px, supersampling);
  const int width = width_px * supersampling, height = height_px * supersampling;
  subsamples_ = makeTexture(GL_RGBA32F, width, height);
  depth_ = makeTexture(GL_DEPTH_COMPONENT32F, width, height);
  throwIfGlFailed("making room for " + std::to_string(width) + " × " + std::to_string(height) +
                  " subsamples");
  framebuffer_ = makeFramebuffer(subsamples_, depth_);
  width_px_ = width_px;
  height_px_ = height_px;
  supersampling_ = supersampling;
}

void PictureTarget::beginFrame(float background_alpha) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glViewport(0, 0, width_px_ * supersampling_, height_px_ * supersampling_);
  const float background[4] = {0, 0, 0, background_alpha}, farthest = 1;
  glClearNamedFramebufferfv(framebuffer_.name(), GL_COLOR, 0, background);
  glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &farthest);
}

void PictureTarget::resolve(GLuint framebuffer, float exposure, bool display_encoded) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width_px_, height_px_);
  glDisable(GL_DEPTH_TEST);
  glUseProgram(resolve_program_.name());
  glUniform1i(0, supersampling_);
  glUniform1f(1, exposure);
  glUniform1i(2, display_encoded ? 1 : 0);
  glBindTextureUnit(0, subsamples_.name());
  glBindVertexArray(no_attributes_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void PictureTarget::resolveForDisplay(GLuint framebuffer, float exposure) const {
  resolve(framebuffer, exposure, true);
  throwIfGlFailed("resolving the picture");
}

formats::Image PictureTarget::displayImage(float exposure) const {
  const Texture picture = makeTexture(GL_RGBA8, width_px_, height_px_);
  const Framebuffer framebuffer = makeFramebuffer(picture, {});
  resolve(framebuffer.name(), exposure, true);
  std::vector<std::uint8_t> codes(static_cast<std::size_t>(width_px_) * height_px_ * 4);
  glGetTextureImage(picture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(codes.size()),
                    codes.data());
  throwIfGlFailed("reading the picture back");
  flipRows(codes, width_px_, height_px_);
  formats::Image image(width_px_, height_px_, {"R", "G", "B", "A"});
  std::ranges::transform(codes, image.values.begin(),
                         [](std::uint8_t code) { return static_cast<float>(code) / 255; });
  return image;
}

formats::Image PictureTarget::linearImage() const {
  const Texture picture = makeTexture(GL_RGBA32F, width_px_, height_px_);
  const Framebuffer framebuffer = makeFramebuffer(picture, {});
  resolve(framebuffer.name(), 1, false);
  formats::Image image(width_px_, height_px_, {"R", "G", "B", "A"});
  glGetTextureImage(picture.name(), 0, GL_RGBA, GL_FLOAT,
                    static_cast<GLsizei>(image.values.size() * sizeof(float)), image.values.data());
  throwIfGlFailed("reading the picture back");
  flipRows(image.values, width_px_, height_px_);
  return image;
}

}  // namespace bakelight::player
