#include "tools/player/vertex_radiance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "formats/error.h"
#include "tools/player/gl_context.h"
#include "tools/player/gl_program.h"
#include "transport/sh.h"

namespace bakelight::player {
namespace {

constexpr std::size_t kGroupSize = 64;  // local_size_x of radiance.comp
constexpr std::size_t kRadianceBytes = 3 * sizeof(float);
constexpr std::size_t kLightSize = transport::coefficientCount(transport::kMaxOrder);

// A multiple of the group size, which is at least one group: 64 floats are 256 bytes, the strictest alignment
// that GL allows for the start of a bound range.
std::size_t verticesPerDispatch(std::size_t coefficient_count, std::size_t largest_block_bytes) {
  GLint largest_groups = 0;
  GLint64 largest_block = 0;
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &largest_groups);
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest_block);
  const std::size_t block =
      largest_block_bytes == 0 ? static_cast<std::size_t>(largest_block) : largest_block_bytes;
  const std::size_t bytes_per_vertex = std::max(coefficient_count * sizeof(float), kRadianceBytes);
  const std::size_t groups = std::clamp<std::size_t>(block / (bytes_per_vertex * kGroupSize), 1,
                                                     static_cast<std::size_t>(largest_groups));
  return groups * kGroupSize;
}

}  // namespace

VertexRadiance::VertexRadiance(const formats::DiffuseTransfer& transfer, std::size_t vertex_count,
                               std::size_t largest_block_bytes)
    : vertex_count_(vertex_count),
      coefficient_count_(transport::coefficientCount(transfer.order)),
      vertices_per_dispatch_(verticesPerDispatch(coefficient_count_, largest_block_bytes)),
      dispatches_(static_cast<int>((vertex_count + vertices_per_dispatch_ - 1) / vertices_per_dispatch_)),
      program_(makeProgram({{GL_COMPUTE_SHADER, kRadianceComp}})) {
  if (transfer.vectors.size() != vertex_count * coefficient_count_ || coefficient_count_ > kLightSize)
    throw std::invalid_argument("transfer table and vertex count do not fit together");
  transfer_ = makeBuffer(transfer.vectors.size() * sizeof(float), transfer.vectors.data());
  radiance_ = makeBuffer(vertex_count * kRadianceBytes, nullptr);
  light_ = makeBuffer(kLightSize * sizeof(formats::Float4), nullptr, GL_DYNAMIC_STORAGE_BIT);
  throwIfGlFailed("uploading the transfer table");
}

void VertexRadiance::evaluate(std::span<const transport::Float3> light) {
  if (light.size() < coefficient_count_) throw std::invalid_argument("the light has too few coefficients");
  std::array<formats::Float4, kLightSize> padded{};
  for (std::size_t i = 0; i < coefficient_count_; ++i) {
    for (const float value : light[i])
      if (!std::isfinite(value))
        throw badInput({"", "light coefficient " + std::to_string(i), ""}, "is not a finite number",
                       "a finite number", "another light");
    padded[i] = {light[i][0], light[i][1], light[i][2], 0};
  }
  glNamedBufferSubData(light_.name(), 0, sizeof(padded), padded.data());

  glUseProgram(program_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light_.name());
  glUniform1ui(1, static_cast<GLuint>(coefficient_count_));
  for (std::size_t first = 0; first < vertex_count_; first += vertices_per_dispatch_) {
    const std::size_t count = std::min(vertices_per_dispatch_, vertex_count_ - first);
    const std::size_t row_bytes = coefficient_count_ * sizeof(float);
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, transfer_.name(), static_cast<GLintptr>(first * row_bytes),
                      static_cast<GLsizeiptr>(count * row_bytes));
    glBindBufferRange(GL_SHADER_STORAGE_BUFFER, 1, radiance_.name(),
                      static_cast<GLintptr>(first * kRadianceBytes),
                      static_cast<GLsizeiptr>(count * kRadianceBytes));
    glUniform1ui(0, static_cast<GLuint>(count));
    glDispatchCompute(static_cast<GLuint>((count + kGroupSize - 1) / kGroupSize), 1, 1);
  }
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("evaluating the light");
}

}  // namespace bakelight::player
