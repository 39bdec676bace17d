#include "tools/player/lights/near_field_lights.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/cube_map.h"

namespace bakelight::player {
namespace {

using formats::Float3;
using transport::Vec3;

void requireResolution(int order, int resolution) {
  GLint64 largest = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  const double texel_bytes = 6.0 * transport::coefficientCount(order) * sizeof(float);
  if (texel_bytes * resolution * resolution <= static_cast<double>(largest)) return;
  const int fitting = static_cast<int>(std::sqrt(static_cast<double>(largest) / texel_bytes));
  throw badInput({"", "cube map", ""},
                 std::to_string(resolution) + " texels a side are too many for this OpenGL at order " +
                     std::to_string(order),
                 "at most " + std::to_string(fitting), "a smaller cube_resolution");
}

// Reversed depth, near / distance: 32-bit floats then resolve all distances alike, so that the near plane may
// stand as close to the centre as no emitter would. Needs glClipControl's depth from 0 to 1.
Eigen::Matrix4d clipFromCenter(int face, double near_plane) {
  // The directions of the face's middle and of what its edges add (OpenGL 4.5, table 8.19).
  const Vec3 middle = transport::directionOfCubeFace(face, 0.5, 0.5);
  const Vec3 right = (transport::directionOfCubeFace(face, 1, 0.5) * std::sqrt(2) - middle);
  const Vec3 down = (transport::directionOfCubeFace(face, 0.5, 1) * std::sqrt(2) - middle);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip.row(0).head<3>() = right;
  clip.row(1).head<3>() =
      down;  // row 0 of a texture is the lower edge of what is drawn, and the upper of a face
  clip(2, 3) = near_plane;
  clip.row(3).head<3>() = middle;
  return clip;
}

}  // namespace

NearFieldLights::NearFieldLights(formats::LightRig rig, const transport::BoundingSphere& object,
                                 const Vec3& center, int order, int resolution_px)
    : rig_(std::move(rig)),
      object_(object),
      center_(center),
      order_(order),
      resolution_(resolution_px),
      light_(darkLight()) {
  requireResolution(order, resolution_px);
  makeCube();
  makeProjection();
  upload(transport::emitterMesh(rig_, object_, 0));
  throwIfGlFailed("preparing the near lights");
}

void NearFieldLights::makeCube() {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  faces_ = Texture(name);
  glTextureStorage3D(name, 1, GL_RGBA32F, resolution_, resolution_, transport::kCubeFaces);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  depth_ = makeTexture(GL_DEPTH_COMPONENT32F, resolution_, resolution_);
  for (int face = 0; face < transport::kCubeFaces; ++face)
    face_framebuffers_[face] = makeLayerFramebuffer(faces_, face, depth_);
}

void NearFieldLights::makeProjection() {
  const std::size_t count = transport::coefficientCount(order_);
  const std::size_t face_texels = static_cast<std::size_t>(resolution_) * resolution_;
  const std::size_t texels = transport::kCubeFaces * face_texels;
  std::vector<float> weighted_basis(count * texels);
  std::vector<double> basis(count);
  for (int face = 0; face < transport::kCubeFaces; ++face)
    for (int y = 0; y < resolution_; ++y)
      for (int x = 0; x < resolution_; ++x) {
        transport::evaluateSh(
            order_, transport::directionOfCubeFace(face, (x + 0.5) / resolution_, (y + 0.5) / resolution_),
            basis);
        const double solid_angle_sr = transport::cubeTexelSolidAngle(x, y, resolution_);
        const std::size_t texel = face * face_texels + static_cast<std::size_t>(y) * resolution_ + x;
        for (std::size_t i = 0; i < count; ++i)
          weighted_basis[i * texels + texel] = static_cast<float>(basis[i] * solid_angle_sr);
      }
  weighted_basis_ = makeBuffer(weighted_basis.size() * sizeof(float), weighted_basis.data());
  row_sums_ = makeBuffer(transport::kCubeFaces * resolution_ * count * sizeof(formats::Float4), nullptr);
  row_program_ = makeComputeProgram({kProjectRowsComp});
  sum_program_ = makeComputeProgram({kProjectSumComp});
}

void NearFieldLights::upload(const transport::EmitterMesh& emitters) {
  const auto& [mesh, radiance] = emitters;
  const GLsizei index_count = indexCountOf(mesh.triangleCount(), "emitters", "simpler or fewer emitters");
  for (const Float3& color : radiance)
    for (const float value : color)
      if (!std::isfinite(value))
        throw badInput({"", "emitters", ""}, "an emitter's radiance is not finite", "finite numbers",
                       "mending the light rig");
  vertex_count_ = mesh.vertexCount();
  positions_ = makeBuffer(vertex_count_ * sizeof(Float3), nullptr, GL_DYNAMIC_STORAGE_BIT);
  radiance_ = makeBuffer(vertex_count_ * sizeof(Float3), radiance.data());
  indices_ = makeBuffer(mesh.triangles.size() * sizeof(formats::Triangle), mesh.triangles.data());
  bodies_.emplace(positions_, radiance_, indices_, index_count);
  place(0);
}

void NearFieldLights::place(double time_s) {
  const transport::EmitterMesh emitters = transport::emitterMesh(rig_, object_, time_s);
  if (emitters.mesh.vertexCount() != vertex_count_) throw std::logic_error("emitters change their shape");
  std::vector<Float3> positions;
  positions.reserve(vertex_count_);
  radius_ = 0;
  for (const Float3& position : emitters.mesh.positions) {
    const Vec3 from_object = transport::vec3(position) - object_.center;
    radius_ = std::max(radius_, from_object.norm());
    positions.push_back(transport::float3(from_object));
  }
  glNamedBufferSubData(positions_.name(), 0, static_cast<GLsizeiptr>(vertex_count_ * sizeof(Float3)),
                       positions.data());
}

void NearFieldLights::project(const Eigen::Matrix3d& world_from_object) {
  drawCube(world_from_object);
  projectCube();
  ++light_.revision;
  throwIfGlFailed("projecting the near lights");
}

void NearFieldLights::drawCube(const Eigen::Matrix3d& world_from_object) const {
  const GpuPass pass("cube map");
  constexpr double kNearShare = 1e-6;  // of the object's size
  Eigen::Matrix4d center_from_position = Eigen::Matrix4d::Identity();
  center_from_position.topLeftCorner<3, 3>() = world_from_object.transpose();
  center_from_position.topRightCorner<3, 1>() = object_.center - center_;
  const float black[4] = {0, 0, 0, 0}, farthest = 0;
  const double near_plane = kNearShare * std::max(object_.radius, radius_);

  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  glEnable(GL_DEPTH_TEST);
  glViewport(0, 0, resolution_, resolution_);
  for (int face = 0; face < transport::kCubeFaces; ++face) {
    const GLuint framebuffer = face_framebuffers_[face].name();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, black);
    glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    draw((clipFromCenter(face, near_plane) * center_from_position).cast<float>());
  }
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  glDepthFunc(GL_LESS);
}

void NearFieldLights::projectCube() const {
  const GpuPass pass("cube map projection");
  const auto count = static_cast<GLuint>(transport::coefficientCount(order_));
  const auto rows = static_cast<GLuint>(transport::kCubeFaces * resolution_);
  glUseProgram(row_program_.name());
  glBindTextureUnit(0, faces_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, row_sums_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, weighted_basis_.name());
  glUniform1ui(0, count);
  dispatchItems(static_cast<std::size_t>(rows) * count);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  glUseProgram(sum_program_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, light_.sh.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, row_sums_.name());
  glUniform1ui(0, count);
  glUniform1ui(1, rows);
  dispatchItems(count);
  glMemoryBarrier(GL_UNIFORM_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void NearFieldLights::draw(const Eigen::Matrix4f& clip_from_position) const {
  bodies_->draw(clip_from_position);
}

transport::ShLight NearFieldLights::readLight() const {
  std::vector<formats::Float4> padded(transport::coefficientCount(order_));
  glGetNamedBufferSubData(light_.sh.name(), 0, static_cast<GLsizeiptr>(padded.size() * sizeof(padded[0])),
                          padded.data());
  transport::ShLight light;
  for (const auto& value : padded) light.push_back({value[0], value[1], value[2]});
  return light;
}

formats::Image NearFieldLights::readCube() const {
  std::vector<Float3> texels(static_cast<std::size_t>(transport::kCubeFaces) * resolution_ * resolution_);
  glGetTextureImage(faces_.name(), 0, GL_RGB, GL_FLOAT, static_cast<GLsizei>(texels.size() * sizeof(Float3)),
                    texels.data());
  throwIfGlFailed("reading the cube map back");
  formats::Image strip(transport::kCubeFaces * resolution_, resolution_, {"R", "G", "B"});
  std::size_t texel = 0;
  for (int face = 0; face < transport::kCubeFaces; ++face)
    for (int y = 0; y < resolution_; ++y)
      for (int x = 0; x < resolution_; ++x)
        std::ranges::copy(texels[texel++], strip.texel(face * resolution_ + x, y));
  return strip;
}

bool NearFieldLights::anyMoves() const {
  return std::ranges::any_of(rig_.emitters, [](const formats::Emitter& emitter) {
    return emitter.motion.kind != formats::Motion::Kind::kStill;
  });
}

std::size_t NearFieldLights::gpuBytes() const {
  const std::size_t texels = static_cast<std::size_t>(transport::kCubeFaces) * resolution_ * resolution_;
  const std::size_t cube = texels * sizeof(formats::Float4) + texels / transport::kCubeFaces * sizeof(float);
  return cube + sizeInBytes(positions_) + sizeInBytes(radiance_) + sizeInBytes(indices_) +
         sizeInBytes(weighted_basis_) + sizeInBytes(row_sums_) + sizeInBytes(light_.sh);
}

}  // namespace bakelight::player
