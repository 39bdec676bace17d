// The exit radiance of each vertex, on the GPU: which passes a pack and its lights need, and when they run.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "formats/pack_contents.h"
#include "tools/player/diffuse_pass.h"
#include "tools/player/glossy_pass.h"
#include "tools/player/transfer_pass.h"
#include "transport/lights.h"

namespace bakelight::player {

class ExitRadiance {
 public:
  // Uploads the tables that are played. `near_light` is the light buffer (gpu_light.h) of what near emitters
  // send to the virtual sphere's centre, and outlives this; null without emitters, whose tables and buffers
  // are left out then, as those of glossiness are for a diffuse pack. Positions on the GPU are counted from
  // `origin`.
  ExitRadiance(const formats::Pack& pack, const transport::Vec3& origin, const Buffer* near_light);

  // Distant light in the object's frame, at least order² entries. Throws Error(kBadInput) if one of them is
  // not finite.
  void setDistantLight(std::span<const transport::Float3> light);
  void nearLightHasChanged() { near_is_stale_ = true; }
  // Runs the passes that depend on the light, if it has changed.
  void update();
  // Runs the passes that depend on the eye (object space), if there are any, after an update().
  void lookFrom(const transport::Vec3& eye);

  // n × RGB float32: the same buffer for the whole life, fit for a vertex attribute.
  const Buffer& buffer() const;
  std::size_t gpuBytes() const;

 private:
  void sumLights();

  int order_;
  GpuTable vectors_, near_vectors_;
  Buffer vertex_colors_, distant_light_, total_light_;
  const Buffer* near_light_;
  bool distant_is_stale_ = true, near_is_stale_ = true;
  std::optional<DiffusePass> distant_, near_;
  std::optional<TransferPass> transfer_;
  std::optional<GlossyPass> glossy_;
  Program sum_program_;
};

}  // namespace bakelight::player
