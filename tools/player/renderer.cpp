#include "tools/player/renderer.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "tools/player/gl_context.h"
#include "tools/player/gl_program.h"

namespace bakelight::player {
namespace {

enum Attribute : GLuint { kPosition = 0, kRadiance = 1 };  // locations in surface.vert

// Positions go to the GPU from the sphere's centre: an object far from the origin keeps its float digits.
std::vector<formats::Float3> centered(const formats::TriangleMesh& mesh, const transport::Vec3& center) {
  std::vector<formats::Float3> positions;
  positions.reserve(mesh.positions.size());
  for (const auto& position : mesh.positions)
    positions.push_back(transport::float3(transport::vec3(position) - center));
  return positions;
}

std::optional<NearFieldLights> nearLights(const formats::Pack& pack, const transport::BoundingSphere& bounds,
                                          transport::Lighting& lighting) {
  if (lighting.near.emitters.empty()) return std::nullopt;
  const formats::ShTransfer& transfer = pack.sh();
  const transport::Vec3 center =
      transfer.near_field ? transport::vec3(transfer.near_field->center) : bounds.center;
  return std::optional<NearFieldLights>(std::in_place, std::move(lighting.near), bounds, center,
                                        transfer.order, lighting.cube_resolution);
}

Eigen::Matrix3d objectFromLight(const formats::FrameSettings& settings) {
  return transport::worldFromObject(settings).transpose() * transport::worldFromLight(settings);
}

void setUniform(GLint location, const transport::Vec3& value) {
  const Eigen::Vector3f v = value.cast<float>();
  glUniform3fv(location, 1, v.data());
}

}  // namespace

Renderer::Renderer(const formats::Pack& pack, transport::Lighting lighting)
    : bounds_(transport::boundingSphere(pack.mesh)),
      order_(pack.sh().order),
      distant_(std::move(lighting.distant)),
      exposure_light_(distant_),
      near_lights_(nearLights(pack, bounds_, lighting)),
      exit_radiance_(pack, bounds_.center, near_lights_ ? &near_lights_->light() : nullptr),
      surface_program_(
          makeProgram({{GL_VERTEX_SHADER, {kSurfaceVert}}, {GL_FRAGMENT_SHADER, {kSurfaceFrag}}})),
      backdrop_program_(
          makeProgram({{GL_VERTEX_SHADER, {kFullscreenVert}}, {GL_FRAGMENT_SHADER, {kBackdropFrag}}})),
      no_attributes_(makeVertexArray()) {
  uploadMesh(pack);
  uploadBackdrop(lighting.backdrop);
  if (near_lights_) {
    near_lights_->project(Eigen::Matrix3d::Identity());
    exposure_light_ = transport::sum(distant_, near_lights_->readLight());
  }
}

void Renderer::uploadMesh(const formats::Pack& pack) {
  const auto& triangles = pack.mesh.triangles;
  if (triangles.size() > static_cast<std::size_t>(std::numeric_limits<GLsizei>::max()) / 3)
    throw badInput({"", "mesh", ""},
                   std::to_string(triangles.size()) + " triangles are too many for one draw call",
                   "at most 715827882 triangles", "a simplified mesh");
  index_count_ = static_cast<GLsizei>(triangles.size() * 3);
  indices_ = makeBuffer(triangles.size() * sizeof(formats::Triangle), triangles.data());
  positions_ = makeBuffer(pack.mesh.vertexCount() * sizeof(formats::Float3),
                          centered(pack.mesh, bounds_.center).data());

  surface_ = makeVertexArray();
  const GLuint surface = surface_.name();
  const auto attribute = [surface](Attribute location, const Buffer& buffer) {
    glVertexArrayVertexBuffer(surface, location, buffer.name(), 0, sizeof(formats::Float3));
    glEnableVertexArrayAttrib(surface, location);
    glVertexArrayAttribFormat(surface, location, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(surface, location, location);
  };
  attribute(kPosition, positions_);
  attribute(kRadiance, exit_radiance_.buffer());
  glVertexArrayElementBuffer(surface, indices_.name());
  throwIfGlFailed("uploading the mesh");
}

void Renderer::uploadBackdrop(const formats::Image& image) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (std::max(image.width, image.height) > largest)
    throw badInput({"", "environment", ""},
                   "is " + std::to_string(image.width) + " × " + std::to_string(image.height) + " pixels",
                   "at most " + std::to_string(largest) + " pixels a side on this OpenGL", "a smaller image");
  backdrop_ = makeTexture(GL_RGB32F, image.width, image.height);
  glTextureSubImage2D(backdrop_.name(), 0, 0, 0, image.width, image.height, GL_RGB, GL_FLOAT,
                      image.values.data());
  backdrop_bytes_ = image.values.size() * sizeof(float);
  throwIfGlFailed("uploading the environment");
}

void Renderer::updateLight(const formats::FrameSettings& settings) {
  evaluated_.object_from_light = objectFromLight(settings);
  const transport::ShRotation rotation(order_, evaluated_.object_from_light);
  exit_radiance_.setDistantLight(rotation.apply(distant_));
  exit_radiance_.update();
}

void Renderer::updateNearLight(const formats::FrameSettings& settings) {
  if (!near_lights_) return;
  evaluated_.world_from_object = transport::worldFromObject(settings);
  evaluated_.time_s = settings.time_s;
  near_lights_->place(settings.time_s);
  near_lights_->project(evaluated_.world_from_object);
  exit_radiance_.nearLightHasChanged();
}

void Renderer::updateStaleLights(const formats::FrameSettings& settings) {
  if (near_lights_ && (evaluated_.time_s != settings.time_s ||
                       evaluated_.world_from_object != transport::worldFromObject(settings)))
    updateNearLight(settings);
  if (evaluated_.object_from_light != objectFromLight(settings)) updateLight(settings);
  exit_radiance_.update();
}

float Renderer::exposure(const formats::FrameSettings& settings) const {
  return static_cast<float>(transport::exposureFactor(settings, exposure_light_));
}

void Renderer::draw(const formats::FrameSettings& settings) {
  const transport::OrbitCamera camera = transport::frameCamera(settings, bounds_);
  const Eigen::Matrix3d world_from_object = transport::worldFromObject(settings);
  updateStaleLights(settings);
  exit_radiance_.lookFrom(world_from_object.transpose() * (camera.eye() - bounds_.center) + bounds_.center);

  target_.resize(settings.width_px, settings.height_px, settings.supersampling);
  target_.beginFrame(settings.background == formats::Background::kTransparent ? 0.0f : 1.0f);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);  // the backdrop lies at the far plane itself
  drawBodies(camera, world_from_object);
  if (settings.background == formats::Background::kEnvironment)
    drawBackdrop(camera, transport::worldFromLight(settings));
  throwIfGlFailed("drawing");
}

void Renderer::drawBodies(const transport::OrbitCamera& camera,
                          const Eigen::Matrix3d& world_from_object) const {
  // Both sides are drawn, as rays hit both: open meshes show their inside.
  transport::BoundingSphere all = bounds_;
  if (near_lights_) all.radius = std::max(all.radius, near_lights_->radius());
  const double aspect = static_cast<double>(target_.widthPx()) / target_.heightPx();
  const Eigen::Affine3d world_from_centered(Eigen::Translation3d(bounds_.center));
  const Eigen::Matrix4d clip_from_centered =
      camera.clipFromView(aspect, all) * camera.viewFromWorld() * world_from_centered.matrix();
  const Eigen::Matrix4f clip_from_position =
      (clip_from_centered * Eigen::Affine3d(world_from_object).matrix()).cast<float>();
  glUseProgram(surface_program_.name());
  glUniformMatrix4fv(0, 1, GL_FALSE, clip_from_position.data());
  glBindVertexArray(surface_.name());
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
  if (near_lights_) near_lights_->draw(clip_from_centered.cast<float>());
}

void Renderer::drawBackdrop(const transport::OrbitCamera& camera,
                            const Eigen::Matrix3d& world_from_light) const {
  // Rows of viewFromWorld: right, up, backward.
  const Eigen::Matrix3d world_from_view = camera.viewFromWorld().topLeftCorner<3, 3>().transpose();
  const Eigen::Matrix3d light_from_view = world_from_light.transpose() * world_from_view;
  const double half_height = std::tan(camera.field_of_view_deg * std::numbers::pi / 360);
  const double half_width = half_height * target_.widthPx() / target_.heightPx();
  glUseProgram(backdrop_program_.name());
  glUniform2f(0, static_cast<float>(target_.widthPx() * target_.supersampling()),
              static_cast<float>(target_.heightPx() * target_.supersampling()));
  setUniform(1, -light_from_view.col(2));
  setUniform(2, light_from_view.col(0) * half_width);
  setUniform(3, light_from_view.col(1) * half_height);
  glBindTextureUnit(0, backdrop_.name());
  glBindVertexArray(no_attributes_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

std::size_t Renderer::gpuBytes() const {
  return exit_radiance_.gpuBytes() + sizeInBytes(positions_) + sizeInBytes(indices_) + backdrop_bytes_ +
         (near_lights_ ? near_lights_->gpuBytes() : 0);
}

}  // namespace bakelight::player
