#include "tools/player/lights/backdrop.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"

namespace bakelight::player {
namespace {

void requireFittingTexture(const formats::Image& image) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (std::max(image.width, image.height) <= largest) return;
  throw badInput({"", "environment", ""},
                 "is " + std::to_string(image.width) + " × " + std::to_string(image.height) + " pixels",
                 "at most " + std::to_string(largest) + " pixels a side on this OpenGL", "a smaller image");
}

void setUniform(GLint location, const transport::Vec3& value) {
  const Eigen::Vector3f v = value.cast<float>();
  glUniform3fv(location, 1, v.data());
}

}  // namespace

Backdrop::Backdrop(const formats::Image& image)
    : program_(makeProgram({{GL_VERTEX_SHADER, {kFullscreenVert}}, {GL_FRAGMENT_SHADER, {kBackdropFrag}}})),
      no_attributes_(makeVertexArray()),
      bytes_(image.values.size() * sizeof(float)) {
  requireFittingTexture(image);
  image_ = makeTexture(GL_RGB32F, image.width, image.height);
  glTextureSubImage2D(image_.name(), 0, 0, 0, image.width, image.height, GL_RGB, GL_FLOAT,
                      image.values.data());
  throwIfGlFailed("uploading the environment");
}

void Backdrop::draw(const transport::OrbitCamera& camera, const Eigen::Matrix3d& world_from_light, int width,
                    int height) const {
  const GpuPass pass("backdrop");
  // Rows of viewFromWorld: right, up, backward.
  const Eigen::Matrix3d world_from_view = camera.viewFromWorld().topLeftCorner<3, 3>().transpose();
  const Eigen::Matrix3d light_from_view = world_from_light.transpose() * world_from_view;
  const double half_height = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double half_width = half_height * width / height;
  glUseProgram(program_.name());
  glUniform2f(0, static_cast<float>(width), static_cast<float>(height));
  setUniform(1, -light_from_view.col(2));
  setUniform(2, light_from_view.col(0) * half_width);
  setUniform(3, light_from_view.col(1) * half_height);
  glBindTextureUnit(0, image_.name());
  glBindVertexArray(no_attributes_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace bakelight::player
