// What is around an object and gets its shadow: a ground, a receiver that moves. The object does not see them.
#pragma once

#include <cstddef>
#include <Eigen/Core>
#include <optional>

#include "formats/pack_contents.h"
#include "formats/words.h"
#include "tools/player/lights/gpu_light.h"
#include "tools/player/lights/total_light.h"
#include "tools/player/surroundings/ground.h"
#include "tools/player/surroundings/receiver.h"

namespace bakelight::player {

enum class ShownGround {
  kAuto,  // where the pack has one and the background is not transparent
  kOn,    // where the pack has one
  kOff
};
inline constexpr formats::Word<ShownGround> kShownGrounds[] = {
    {"auto", ShownGround::kAuto}, {"on", ShownGround::kOn}, {"off", ShownGround::kOff}};

struct SurroundingsOptions {
  ShownGround ground = ShownGround::kAuto;
  formats::Float3 ground_albedo = {0.5F, 0.5F, 0.5F};
  std::optional<transport::Receiver> receiver = {};
};

// Bands of the light that a pack's neighborhood needs; 0 without one.
int neighborhoodOrder(const formats::Pack& pack);

class Surroundings {
 public:
  // With `near_light`, setLight always gets some. Throws std::invalid_argument if a receiver is asked for and the pack has no volume.
  Surroundings(const formats::Pack& pack, const SurroundingsOptions& options,
               const transport::BoundingSphere& object, bool near_light);

  // In the object's frame; does nothing if neither has changed.
  void setLight(const GpuLight& distant, const GpuLight* near);
  void place(const Eigen::Matrix3d& world_from_object, double time_s);
  // Before the backdrop, and behind it. Positions are from the object's middle.
  void drawReceiver(const Eigen::Matrix4d& clip_from_centered) const;
  void drawGround(const Eigen::Matrix4d& clip_from_centered, const Eigen::Matrix3d& world_from_object,
                  bool transparent) const;

  double radius() const;  // from the object's middle, of all that may be drawn
  bool moves() const { return options_.receiver && options_.receiver->orbit_s > 0; }
  std::size_t gpuBytes() const;

 private:
  SurroundingsOptions options_;
  TotalLight light_;
  std::optional<Ground> ground_;
  std::optional<Receiver> receiver_;
};

}  // namespace bakelight::player
