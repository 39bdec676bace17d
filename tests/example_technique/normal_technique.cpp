#include "tests/example_technique/normal_technique.h"

#include <stdexcept>

#include "tests/example_technique/normal_reflection.h"
#include "tests/example_technique/normal_shaders.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"

namespace bakelight::example {
namespace {

enum Attribute : GLuint { kPosition = 0, kNormal = 1 };            // locations in normals.vert
enum Uniform : GLint { kClipFromPosition = 0, kEye = 1 };          // in both shaders
enum UniformBlock : GLuint { kDistantLight = 0, kNearLight = 1 };  // in normals.frag

}  // namespace

NormalTechnique::NormalTechnique(const formats::Pack& pack, const player::SurfaceMesh& mesh, bool near_light)
    : mesh_(mesh),
      normals_(
          player::makeBuffer(pack.mesh.normals.size() * sizeof(transport::Float3), pack.mesh.normals.data())),
      program_(player::makeProgram(
          {{GL_VERTEX_SHADER, {kNormalsVert}},
           {GL_FRAGMENT_SHADER, {kNormalsFrag}, near_light ? "#define NEAR_LIGHT\n" : ""}})),
      vertices_(
          player::makeVertexArray(mesh.indices(), {{kPosition, &mesh.positions()}, {kNormal, &normals_}})) {
  const NormalReflection* reflection = normalReflectionOf(pack);
  if (reflection == nullptr || pack.mesh.normals.size() != pack.mesh.vertexCount())
    throw std::invalid_argument("shading by normals needs a picture and a normal a vertex");
  const formats::PackImage& picture = reflection->picture;
  const std::vector<float> texels = picture.texels.decode();
  picture_ = player::makeTexture(GL_RGB32F, picture.width, picture.height);
  glTextureSubImage2D(picture_.name(), 0, 0, 0, picture.width, picture.height, GL_RGB, GL_FLOAT,
                      texels.data());
  picture_bytes_ = texels.size() * sizeof(float);
  player::throwIfGlFailed("uploading the picture by normals");
}

void NormalTechnique::setLight(const player::GpuLight& distant, const player::GpuLight* near) {
  distant_ = &distant;
  near_ = near;
}

void NormalTechnique::lookFrom(const transport::ViewPoint& view) {
  eye_ = transport::float3(view.eye - mesh_.origin());
}

void NormalTechnique::draw(const Eigen::Matrix4f& clip_from_position) const {
  const player::GpuPass pass("surface");
  glUseProgram(program_.name());
  glUniformMatrix4fv(kClipFromPosition, 1, GL_FALSE, clip_from_position.data());
  glUniform3fv(kEye, 1, eye_.data());
  glBindBufferBase(GL_UNIFORM_BUFFER, kDistantLight, distant_->sh.name());
  if (near_ != nullptr) glBindBufferBase(GL_UNIFORM_BUFFER, kNearLight, near_->sh.name());
  glBindTextureUnit(0, picture_.name());
  glBindVertexArray(vertices_.name());
  glDrawElements(GL_TRIANGLES, mesh_.indexCount(), GL_UNSIGNED_INT, nullptr);
}

std::size_t NormalTechnique::gpuBytes() const {
  return player::sizeInBytes(normals_) + picture_bytes_;
}

player::PlayedTechnique normalTechnique() {
  return {"normals", [](const formats::Pack& pack) { return normalReflectionOf(pack) != nullptr; },
          [](const formats::Pack&) { return transport::LightNeeds{1}; },
          [](const formats::Pack& pack, const player::SurfaceMesh& mesh,
             bool near_light) -> std::unique_ptr<player::Technique> {
            return std::make_unique<NormalTechnique>(pack, mesh, near_light);
          }};
}

}  // namespace bakelight::example
