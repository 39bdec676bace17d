#include "tools/player/techniques/translucent.h"

#include <utility>
#include <vector>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"

namespace bakelight::player {
namespace {

enum Attribute : GLuint { kPosition = 0, kNormal = 1, kStain = 2, kTexcoord = 3 };  // translucent.vert
enum Uniform : GLint { kClipFromPosition = 0, kEye = 1, kNormalReflectance = 2 };   // both shaders

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

std::vector<transport::Float3> coefficientsOf(const GpuLight& light, int order) {
  std::vector<formats::Float4> padded(static_cast<std::size_t>(order) * order);
  glGetNamedBufferSubData(light.sh.name(), 0, static_cast<GLsizeiptr>(padded.size() * sizeof(padded[0])),
                          padded.data());
  std::vector<transport::Float3> coefficients;
  for (const formats::Float4& c : padded) coefficients.push_back({c[0], c[1], c[2]});
  return coefficients;
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

Translucent::Translucent(const formats::Pack& pack, const SurfaceMesh& mesh)
    : shading_(pack),
      origin_(mesh.origin()),
      normals_(bufferOf(pack.mesh.normals)),
      texcoords_(bufferOf(pack.mesh.texcoords)),
      stain_(bufferOf(shading_.stain())),
      texel_light_(pack, mesh, normals_),
      radiosity_(makeTexture(GL_RGBA32F, shading_.resolution(), shading_.resolution())),
      program_(
          makeProgram({{GL_VERTEX_SHADER, {kTranslucentVert}}, {GL_FRAGMENT_SHADER, {kTranslucentFrag}}})),
      vertices_(makeVertexArray(mesh.indices(),
                                {{kPosition, &mesh.positions()}, {kNormal, &normals_}, {kStain, &stain_}})),
      index_count_(mesh.indexCount()) {
  const GLuint name = vertices_.name();
  glVertexArrayVertexBuffer(name, kTexcoord, texcoords_.name(), 0, sizeof(formats::Float2));
  glEnableVertexArrayAttrib(name, kTexcoord);
  glVertexArrayAttribFormat(name, kTexcoord, 2, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(name, kTexcoord, kTexcoord);
  throwIfGlFailed("uploading a translucent object");
}

void Translucent::setLight(const GpuLight& distant, const GpuLight* near) {
  const std::uint64_t near_revision = near == nullptr ? kNone : near->revision;
  if (distant.revision == distant_revision_ && near_revision == near_revision_ && !punctual_is_new_) return;
  distant_revision_ = distant.revision, near_revision_ = near_revision;
  if (std::exchange(punctual_is_new_, false)) takePunctualLight();
  const int order = shading_.needs().sh_order;
  const std::vector<transport::Float3> near_light =
      near == nullptr ? std::vector<transport::Float3>() : coefficientsOf(*near, order);
  shading_.setLight(coefficientsOf(distant, order), near_light);
  glTextureSubImage2D(radiosity_.name(), 0, 0, 0, shading_.resolution(), shading_.resolution(), GL_RGBA,
                      GL_FLOAT, shading_.radiosity().data());
  throwIfGlFailed("lighting a translucent object");
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

void Translucent::takePunctualLight() {
  std::vector<transport::Float3> entering(has_punctual_ ? texel_light_.texelCount() : 0);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  if (has_punctual_)
    glGetNamedBufferSubData(punctual_.name(), 0,
                            static_cast<GLsizeiptr>(entering.size() * sizeof(entering[0])), entering.data());
  shading_.setPunctualLight(std::move(entering));
}

void Translucent::lookFrom(const transport::ViewPoint& view) {
  eye_ = view.eye - origin_;
}

void Translucent::draw(const Eigen::Matrix4f& clip_from_position) const {
  const GpuPass pass("surface");
  const double eta = shading_.relativeIor();
  glUseProgram(program_.name());
  glUniformMatrix4fv(kClipFromPosition, 1, GL_FALSE, clip_from_position.data());
  const Eigen::Vector3f eye = eye_.cast<float>();
  glUniform3fv(kEye, 1, eye.data());
  glUniform1f(kNormalReflectance, static_cast<float>((eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1))));
  glBindTextureUnit(0, radiosity_.name());
  glBindVertexArray(vertices_.name());
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
}

std::size_t Translucent::gpuBytes() const {
  return sizeInBytes(normals_) + sizeInBytes(texcoords_) + sizeInBytes(stain_) + sizeInBytes(punctual_) +
         texel_light_.gpuBytes() + shading_.radiosity().size() * sizeof(formats::Float4);
}

}  // namespace bakelight::player
