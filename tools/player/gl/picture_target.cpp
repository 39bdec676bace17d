#include "tools/player/gl/picture_target.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"

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
void flipRows(formats::Image& image) {
  const std::size_t row = static_cast<std::size_t>(image.width) * image.channelCount();
  for (int y = 0; y < image.height / 2; ++y)
    std::swap_ranges(image.texel(0, y), image.texel(0, y) + row, image.texel(0, image.height - 1 - y));
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
  const GpuPass pass("resolve");
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

void PictureTarget::resolve(const ResolvedPicture& picture, float exposure) const {
  resolve(picture.framebuffer(), exposure, picture.encoding() == PictureEncoding::kDisplay);
  throwIfGlFailed("resolving the picture");
}

formats::Image PictureTarget::displayImage(float exposure) const {
  const ResolvedPicture picture(PictureEncoding::kDisplay, width_px_, height_px_);
  resolve(picture, exposure);
  return picture.read();
}

formats::Image PictureTarget::linearImage() const {
  const ResolvedPicture picture(PictureEncoding::kLinear, width_px_, height_px_);
  resolve(picture, 1);
  return picture.read();
}

ResolvedPicture::ResolvedPicture(PictureEncoding encoding, int width_px, int height_px)
    : encoding_(encoding),
      width_px_(width_px),
      height_px_(height_px),
      texture_(
          makeTexture(encoding == PictureEncoding::kDisplay ? GL_RGBA8 : GL_RGBA32F, width_px, height_px)),
      framebuffer_(makeFramebuffer(texture_, {})) {}

formats::Image ResolvedPicture::read() const {
  formats::Image image(width_px_, height_px_, {"R", "G", "B", "A"});
  if (encoding_ == PictureEncoding::kLinear) {
    glGetTextureImage(texture_.name(), 0, GL_RGBA, GL_FLOAT,
                      static_cast<GLsizei>(image.values.size() * sizeof(float)), image.values.data());
  } else {
    std::vector<std::uint8_t> codes(image.values.size());
    glGetTextureImage(texture_.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(codes.size()),
                      codes.data());
    std::ranges::transform(codes, image.values.begin(),
                           [](std::uint8_t code) { return static_cast<float>(code) / 255; });
  }
  throwIfGlFailed("reading the picture back");
  flipRows(image);
  return image;
}

}  // namespace bakelight::player
