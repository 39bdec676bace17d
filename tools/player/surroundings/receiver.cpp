#include "tools/player/surroundings/receiver.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/sh.h"

namespace bakelight::player {
namespace {

constexpr std::size_t kChangeBytes = formats::kReceivedCoefficients * sizeof(formats::Float3);

const formats::VolumeTransfer& volumeOf(const formats::Neighborhood& neighborhood) {
  if (!neighborhood.volume) throw std::invalid_argument("the neighborhood has no volume for a receiver");
  const formats::VolumeTransfer& volume = *neighborhood.volume;
  const std::size_t columns =
      static_cast<std::size_t>(neighborhood.channels * formats::kReceivedCoefficients) *
      static_cast<std::size_t>(transport::coefficientCount(neighborhood.order));
  if (volume.matrices.columns != columns ||
      volume.matrices.rows != volume.axes[0].size() * volume.axes[1].size() * volume.axes[2].size())
    throw std::invalid_argument("the volume's table does not fit its points");
  return volume;
}

Buffer bufferOf(const std::vector<formats::Float3>& values) {
  return makeBuffer(values.size() * sizeof(formats::Float3), values.data());
}

Buffer axesFrom(const formats::VolumeTransfer& volume, const transport::Vec3& origin) {
  std::vector<float> axes;
  for (std::size_t a = 0; a < 3; ++a)
    for (const float at : volume.axes[a])
      axes.push_back(static_cast<float>(static_cast<double>(at) - origin[static_cast<Eigen::Index>(a)]));
  return makeBuffer(axes.size() * sizeof(float), axes.data());
}

}  // namespace

Receiver::Receiver(const formats::Neighborhood& neighborhood, const transport::Receiver& receiver,
                   const transport::BoundingSphere& object)
    : receiver_(receiver),
      object_(object),
      coefficients_(transport::coefficientCount(neighborhood.order)),
      matrices_(volumeOf(neighborhood).matrices),
      ranges_(rowRanges(matrices_.rows(), std::max(matrices_.rowBytes(), kChangeBytes),
                        formats::kReceivedCoefficients)),
      matrix_program_(makeComputeProgram(
          {kTableGlsl, kMatrixComp},
          matrices_.definitions() + "#define CHANNELS " + std::to_string(neighborhood.channels) +
              "\n#define ROW_COEFFICIENTS " + std::to_string(formats::kReceivedCoefficients) +
              "u\n#define COEFFICIENTS " + std::to_string(coefficients_) + "u\n")),
      program_(makeComputeProgram({kReceiverComp})),
      changes_(makeBuffer(matrices_.rows() * kChangeBytes, nullptr)),
      axes_(axesFrom(*neighborhood.volume, object.center)),
      normals_(bufferOf(receiver_.mesh.normals)),
      radiance_(makeBuffer(receiver_.mesh.vertexCount() * sizeof(formats::Float3), nullptr)),
      mesh_(receiver_.mesh, transport::Vec3::Zero()),
      surface_(mesh_.positions(), radiance_, mesh_.indices(), mesh_.indexCount()) {
  for (std::size_t a = 0; a < 3; ++a) counts_[a] = static_cast<GLuint>(neighborhood.volume->axes[a].size());
  throwIfGlFailed("preparing the receiver");
}

void Receiver::setLight(const Buffer& light) {
  const GpuPass pass("neighborhood light");
  light_ = light.name();
  glUseProgram(matrix_program_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light_);
  for (const RowRange& range : ranges_) {
    matrices_.bind(range);
    bindRows(2, changes_, range, kChangeBytes);
    glUniform1ui(0, static_cast<GLuint>(range.count));
    dispatchItems(range.count * formats::kReceivedCoefficients);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  throwIfGlFailed("lighting the neighborhood");
}

void Receiver::place(const Eigen::Matrix3d& world_from_object, double time_s) {
  const GpuPass pass("receiver");
  middle_ = receiver_.middleAt(time_s) * object_.radius;
  const Eigen::Matrix3f object_from_world = world_from_object.transpose().cast<float>();
  const Eigen::Vector3f middle = middle_.cast<float>();
  const auto vertices = static_cast<GLuint>(mesh_.vertexCount());
  glUseProgram(program_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, mesh_.positions().name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, normals_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, radiance_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, changes_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, axes_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light_);
  glUniform1ui(0, vertices);
  glUniformMatrix3fv(1, 1, GL_FALSE, object_from_world.data());
  glUniform3fv(2, 1, middle.data());
  glUniform1f(3, static_cast<float>(receiver_.radius * object_.radius));
  glUniform3fv(4, 1, receiver_.albedo.data());
  glUniform3ui(5, counts_[0], counts_[1], counts_[2]);
  glUniform1ui(6, static_cast<GLuint>(coefficients_));
  dispatchItems(vertices);
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT);
  throwIfGlFailed("lighting the receiver");
}

void Receiver::draw(const Eigen::Matrix4d& clip_from_centered) const {
  const Eigen::Affine3d centered_from_position =
      Eigen::Translation3d(middle_) * Eigen::Scaling(receiver_.radius * object_.radius);
  surface_.draw((clip_from_centered * centered_from_position.matrix()).cast<float>());
}

double Receiver::reach() const {
  return object_.radius * (transport::vec3(receiver_.position).norm() + receiver_.radius);
}

std::size_t Receiver::gpuBytes() const {
  return mesh_.gpuBytes() + matrices_.gpuBytes() + sizeInBytes(changes_) + sizeInBytes(axes_) +
         sizeInBytes(normals_) + sizeInBytes(radiance_);
}

}  // namespace bakelight::player
