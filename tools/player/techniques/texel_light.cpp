#include "tools/player/techniques/texel_light.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/cube_map.h"

namespace bakelight::player {
namespace {

using transport::PlacedPunctualLight;
using transport::TexelIrradiance;
using transport::Vec3;

enum Uniform : GLint {  // texel_light.comp
  kCount,
  kType,
  kLightPosition,
  kIntensity,
  kAxes,
  kCone,
  kHalfSize,
  kNormalReflectance,
  kOffset,
  kViewCount,
  kViewTangent,
  kViewAxes
};

// Of a light that is this many radii or more from the object's centre one view sees it all.
constexpr double kOutside = 1.25;
constexpr double kNearShare = 1e-6;  // of the object's size: the nearest that is seen

struct GpuTriangle {
  std::array<std::uint32_t, 3> corners, neighbours;
  std::array<float, 2> across, down;
};

std::uint32_t code(const TexelIrradiance::Neighbour& neighbour) {
  return neighbour.triangle == TexelIrradiance::kNone ? TexelIrradiance::kNone
                                                      : 4 * neighbour.triangle + neighbour.corner;
}

std::array<float, 2> floats(const std::array<double, 2>& values) {
  return {static_cast<float>(values[0]), static_cast<float>(values[1])};
}

void setVector(GLint uniform, const Vec3& v) {
  const Eigen::Vector3f values = v.cast<float>();
  glUniform3fv(uniform, 1, values.data());
}

}  // namespace

TexelLight::TexelLight(const formats::Pack& pack, const SurfaceMesh& mesh, const Buffer& normals)
    : mesh_(mesh),
      normals_(normals),
      bounds_(transport::boundingSphere(pack.mesh)),
      depth_program_(
          makeProgram({{GL_VERTEX_SHADER, {kDepthVert}}, {GL_FRAGMENT_SHADER, {kLightDepthFrag}}})),
      light_program_(makeComputeProgram({kTexelLightComp})),
      vertices_(makeVertexArray(mesh.indices(), {{0, &mesh.positions()}})) {
  const auto& translucency = *pack.appearances.at(0).reflection.as<formats::Translucency>();
  const TexelIrradiance surface(translucency, pack.mesh);
  const double eta = static_cast<double>(translucency.eta);
  normal_reflectance_ = static_cast<float>((eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)));
  offset_ = static_cast<float>(surface.offset());
  texel_count_ = surface.texels().size();
  texels_ = makeBuffer(surface.texels().size_bytes(), surface.texels().data());
  std::vector<GpuTriangle> triangles;
  for (std::size_t t = 0; t < pack.mesh.triangleCount(); ++t) {
    const TexelIrradiance::Surroundings& around = surface.triangles()[t];
    triangles.push_back({pack.mesh.triangles[t],
                         {code(around.neighbours[0]), code(around.neighbours[1]), code(around.neighbours[2])},
                         floats(around.across),
                         floats(around.down)});
  }
  triangles_ = makeBuffer(triangles.size() * sizeof(GpuTriangle), triangles.data());
  throwIfGlFailed("preparing the texels that lights fall on");
}

TexelLight::Views TexelLight::makeViews(int side, int count) const {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  Views views;
  views.side = std::min(side, static_cast<int>(largest));
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  views.depths = Texture(name);
  glTextureStorage3D(name, 1, GL_R32F, views.side, views.side, count);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  views.hidden = makeTexture(GL_DEPTH_COMPONENT32F, views.side, views.side);
  for (int layer = 0; layer < count; ++layer)
    views.framebuffers.push_back(makeLayerFramebuffer(views.depths, layer, views.hidden));
  throwIfGlFailed("making room for what lights see");
  return views;
}

TexelLight::Eyes TexelLight::eyesOf(const PlacedPunctualLight& light) const {
  const Vec3 way = bounds_.center - light.position;
  const double distance = way.norm();
  Eyes eyes{{}, 1};
  if (distance > kOutside * bounds_.radius) {
    const Vec3 forward = way / distance, right = forward.unitOrthogonal();
    eyes.axes.emplace_back();
    eyes.axes.back() << right.cast<float>(), right.cross(forward).cast<float>(), forward.cast<float>();
    // Its rim stays inside by a texel or two.
    eyes.tangent = static_cast<float>(1.002 * std::tan(std::asin(bounds_.radius / distance)));
    return eyes;
  }
  for (int face = 0; face < transport::kCubeFaces; ++face) {
    const Vec3 forward = transport::directionOfCubeFace(face, 0.5, 0.5),
               right = forward.cross(std::abs(forward.y()) > 0.5 ? Vec3::UnitX() : Vec3::UnitY());
    eyes.axes.emplace_back();
    eyes.axes.back() << right.cast<float>(), right.cross(forward).cast<float>(), forward.cast<float>();
  }
  return eyes;
}

// Reversed depth, as NearFieldLights has it.
void TexelLight::look(const PlacedPunctualLight& light, const Eyes& eyes, const Views& views) const {
  const GpuPass pass("shadow map");
  const Eigen::Vector3f position = (light.position - mesh_.origin()).cast<float>();
  const float nothing[4] = {0, 0, 0, 0}, farthest = 0;
  glUseProgram(depth_program_.name());
  glBindVertexArray(vertices_.name());
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glDepthFunc(GL_GREATER);
  glEnable(GL_DEPTH_TEST);
  glViewport(0, 0, views.side, views.side);
  for (std::size_t i = 0; i < eyes.axes.size(); ++i) {
    Eigen::Matrix4f clip = Eigen::Matrix4f::Zero();
    clip.row(0).head<3>() = eyes.axes[i].col(0).transpose() / eyes.tangent;
    clip.row(1).head<3>() = eyes.axes[i].col(1).transpose() / eyes.tangent;
    clip.row(3).head<3>() = eyes.axes[i].col(2).transpose();
    clip.col(3) = -clip.leftCols<3>() * position;
    clip(2, 3) = static_cast<float>(kNearShare * bounds_.radius);
    const GLuint framebuffer = views.framebuffers[i].name();
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glClearNamedFramebufferfv(framebuffer, GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &farthest);
    glUniformMatrix4fv(0, 1, GL_FALSE, clip.data());
    glDrawElements(GL_TRIANGLES, mesh_.indexCount(), GL_UNSIGNED_INT, nullptr);
  }
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  glDepthFunc(GL_LESS);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

void TexelLight::light(const PlacedPunctualLight& light, const Eyes& eyes, const Views& views,
                       const Buffer& entering) {
  const GpuPass pass("punctual light");
  glUseProgram(light_program_.name());
  glUniform1ui(kCount, static_cast<GLuint>(texel_count_));
  glUniform1i(kType, static_cast<GLint>(light.type));
  setVector(kLightPosition, light.position - mesh_.origin());
  setVector(kIntensity, light.intensity.matrix());
  const Eigen::Matrix3f axes = light.axes.cast<float>();
  glUniformMatrix3fv(kAxes, 1, GL_FALSE, axes.data());
  glUniform2f(kCone, static_cast<float>(light.inner), static_cast<float>(light.outer));
  glUniform2f(kHalfSize, static_cast<float>(light.half_width), static_cast<float>(light.half_height));
  glUniform1f(kNormalReflectance, normal_reflectance_);
  glUniform1f(kOffset, offset_);
  glUniform1i(kViewCount, static_cast<GLint>(eyes.axes.size()));
  glUniform1f(kViewTangent, eyes.tangent);
  for (std::size_t i = 0; i < eyes.axes.size(); ++i)
    glUniformMatrix3fv(kViewAxes + static_cast<GLint>(i), 1, GL_FALSE, eyes.axes[i].data());
  const Buffer* buffers[] = {&entering, &texels_, &triangles_, &mesh_.positions(), &normals_};
  for (GLuint binding = 0; binding < std::size(buffers); ++binding)
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffers[binding]->name());
  glBindTextureUnit(0, views.depths.name());
  glBindTextureUnit(1, light.image ? slideOf(light.image).name() : 0);
  dispatchItems(texel_count_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

const Texture& TexelLight::slideOf(const std::shared_ptr<const formats::Image>& image) {
  const auto [found, is_new] = slides_.try_emplace(image.get());
  if (is_new) {
    GLint largest = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (std::max(image->width, image->height) > largest)
      throw badInput({"", "slide", ""},
                     "its picture of " + std::to_string(image->width) + " × " +
                         std::to_string(image->height) + " pixels is too large for this OpenGL",
                     "at most " + std::to_string(largest) + " pixels a side", "a smaller picture");
    found->second = {image, makeTexture(GL_RGB32F, image->width, image->height)};
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glTextureSubImage2D(found->second.texture.name(), 0, 0, 0, image->width, image->height, GL_RGB, GL_FLOAT,
                        image->values.data());
  }
  return found->second.texture;
}

void TexelLight::add(std::span<const PlacedPunctualLight> lights, const Buffer& entering) {
  for (const PlacedPunctualLight& placed : lights) {
    const Eyes eyes = eyesOf(placed);
    Views& views = eyes.axes.size() == 1 ? single_ : cube_;
    if (views.side == 0)
      views = makeViews(eyes.axes.size() == 1 ? kSide : kCubeSide, static_cast<int>(eyes.axes.size()));
    look(placed, eyes, views);
    light(placed, eyes, views, entering);
  }
  throwIfGlFailed("lighting texels");
}

std::size_t TexelLight::gpuBytes() const {
  std::size_t bytes = sizeInBytes(texels_) + sizeInBytes(triangles_);
  for (const Views* views : {&single_, &cube_})
    bytes += (views->framebuffers.size() + 1) * sizeof(float) * views->side * views->side;
  for (const auto& [image, slide] : slides_) bytes += image->values.size() * sizeof(float);
  return bytes;
}

}  // namespace bakelight::player
