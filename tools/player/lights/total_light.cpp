#include "tools/player/lights/total_light.h"

#include <stdexcept>

#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_table.h"
#include "transport/sh.h"

namespace bakelight::player {

TotalLight::TotalLight(bool near_light) : near_light_(near_light) {
  if (!near_light_) return;
  sum_ = std::move(darkLight().sh);
  program_ = makeComputeProgram({kSumLightsComp});
}

bool TotalLight::update(const GpuLight& distant, const GpuLight* near) {
  if (near_light_ && near == nullptr) throw std::invalid_argument("near light is missing");
  const std::uint64_t near_revision = near_light_ ? near->revision : kNone;
  if (distant.revision == distant_revision_ && near_revision == near_revision_) return false;
  distant_revision_ = distant.revision;
  near_revision_ = near_revision;
  total_ = &distant.sh;
  if (!near_light_) return true;
  glUseProgram(program_.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, distant.sh.name());
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, near->sh.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, sum_.name());
  dispatchItems(transport::coefficientCount(transport::kMaxOrder));
  glMemoryBarrier(GL_UNIFORM_BARRIER_BIT);
  total_ = &sum_;
  return true;
}

}  // namespace bakelight::player
