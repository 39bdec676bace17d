#include "tools/player/techniques/translucent.h"

#include <stdexcept>
#include <vector>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/translucent_shading.h"
#include "transport/translucent_tables.h"

namespace bakelight::player {
namespace {

enum Attribute : GLuint { kPosition = 0, kNormal = 1, kStain = 2, kTexcoord = 3 };  // translucent.vert
enum Uniform : GLint { kClipFromPosition = 0, kEye = 1, kNormalReflectance = 2 };   // both shaders

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

const formats::Translucency& translucencyOf(const formats::Pack& pack) {
  const auto& translucency = *pack.appearances.at(0).reflection.as<formats::Translucency>();
  const std::size_t count = pack.mesh.vertexCount();
  if (pack.mesh.normals.size() != count || pack.mesh.texcoords.size() != count ||
      translucency.knots.size() != count || pack.sh().vectors.rows != count ||
      (!pack.colors.empty() && pack.colors.size() != count))
    throw std::invalid_argument(
        "a translucent pack needs normal, texture coordinates, knot and transfer of each vertex");
  return translucency;
}

}  // namespace

bool Translucent::plays(const formats::Pack& pack) {
  return transport::TranslucentShading::shades(pack);
}

transport::LightNeeds Translucent::needs(const formats::Pack& pack) {
  const formats::ShTransfer& transfer = pack.sh();
  transport::LightNeeds needs{transfer.order};
  needs.punctual = true;
  if (transfer.near_field) needs.near_center = transport::vec3(transfer.near_field->center);
  return needs;
}

Translucent::Translucent(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light)
    : eta_(static_cast<double>(translucencyOf(pack).eta)),
      origin_(mesh.origin()),
      normals_(bufferOf(pack.mesh.normals)),
      texcoords_(bufferOf(pack.mesh.texcoords)),
      stain_(bufferOf(transport::stainOf(pack))),
      vectors_(pack.sh().vectors),
      distant_(vectors_, pack.sh().order, pack.sh().channels, {}, false),
      texel_light_(pack, mesh, normals_),
      response_(pack),
      program_(
          makeProgram({{GL_VERTEX_SHADER, {kTranslucentVert}}, {GL_FRAGMENT_SHADER, {kTranslucentFrag}}})),
      vertices_(makeVertexArray(mesh.indices(),
                                {{kPosition, &mesh.positions()}, {kNormal, &normals_}, {kStain, &stain_}})),
      index_count_(mesh.indexCount()) {
  if (near_light) {
    if (pack.sh().near_field) near_vectors_ = GpuTable(pack.sh().near_field->vectors);
    near_.emplace(near_vectors_.empty() ? vectors_ : near_vectors_, pack.sh().order, pack.sh().channels,
                  Albedo{}, true);
  }
  const GLuint name = vertices_.name();
  glVertexArrayVertexBuffer(name, kTexcoord, texcoords_.name(), 0, sizeof(formats::Float2));
  glEnableVertexArrayAttrib(name, kTexcoord);
  glVertexArrayAttribFormat(name, kTexcoord, 2, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(name, kTexcoord, kTexcoord);
  throwIfGlFailed("uploading a translucent object");
}

void Translucent::setLight(const GpuLight& distant, const GpuLight* near) {
  if (near_ && near == nullptr) throw std::invalid_argument("near light is missing");
  const std::uint64_t near_revision = near_ ? near->revision : kNone;
  const bool distant_is_new = distant.revision != distant_revision_;
  if (!distant_is_new && near_revision == near_revision_ && !punctual_is_new_) return;
  {
    const GpuPass pass("illumination");
    if (distant_is_new) distant_.evaluate(distant.sh);
    if (near_ && (distant_is_new || near_revision != near_revision_))
      near_->evaluate(near->sh, &distant_.buffer());
  }
  response_.respond((near_ ? *near_ : distant_).buffer(), has_punctual_ ? &punctual_ : nullptr);
  distant_revision_ = distant.revision, near_revision_ = near_revision;
  punctual_is_new_ = false;
}

void Translucent::setPunctualLights(std::span<const transport::PlacedPunctualLight> lights) {
  if (lights.empty() && !has_punctual_) return;
  if (punctual_.name() == 0)
    punctual_ = makeBuffer(texel_light_.texelCount() * sizeof(transport::Float3), nullptr);
  const float dark = 0;
  glClearNamedBufferData(punctual_.name(), GL_R32F, GL_RED, GL_FLOAT, &dark);
  texel_light_.add(lights, punctual_);
  has_punctual_ = !lights.empty();
  punctual_is_new_ = true;
}

void Translucent::lookFrom(const transport::ViewPoint& view) {
  eye_ = view.eye - origin_;
}

void Translucent::draw(const Eigen::Matrix4f& clip_from_position) const {
  const GpuPass pass("surface");
  glUseProgram(program_.name());
  glUniformMatrix4fv(kClipFromPosition, 1, GL_FALSE, clip_from_position.data());
  const Eigen::Vector3f eye = eye_.cast<float>();
  glUniform3fv(kEye, 1, eye.data());
  glUniform1f(kNormalReflectance, static_cast<float>((eta_ - 1) * (eta_ - 1) / ((eta_ + 1) * (eta_ + 1))));
  glBindTextureUnit(0, response_.radiosity().name());
  glBindVertexArray(vertices_.name());
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
}

std::size_t Translucent::gpuBytes() const {
  return sizeInBytes(normals_) + sizeInBytes(texcoords_) + sizeInBytes(stain_) + sizeInBytes(punctual_) +
         vectors_.gpuBytes() + near_vectors_.gpuBytes() + sizeInBytes(distant_.buffer()) +
         (near_ ? sizeInBytes(near_->buffer()) : 0) + texel_light_.gpuBytes() + response_.gpuBytes();
}

}  // namespace bakelight::player
