// Distant and near light as one, for operators that know no near field.
#pragma once

#include <cstdint>

#include "tools/player/gl/gl_objects.h"
#include "tools/player/lights/gpu_light.h"

namespace bakelight::player {

class TotalLight {
 public:
  TotalLight() = default;
  // Without near light nothing is kept: the distant light is the total.
  explicit TotalLight(bool near_light);

  // Whether either light has changed since the last time; then the total is the one to evaluate. Throws
  // std::invalid_argument if near light was promised and is missing.
  bool update(const GpuLight& distant, const GpuLight* near);
  const Buffer& sh() const { return *total_; }
  std::size_t gpuBytes() const { return sizeInBytes(sum_); }

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  bool near_light_ = false;
  Buffer sum_;
  Program program_;
  const Buffer* total_ = nullptr;
  std::uint64_t distant_revision_ = kNone, near_revision_ = kNone;
};

}  // namespace bakelight::player
