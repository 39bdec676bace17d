// The technique on the CPU: what report, inspect, the CPU renderer and tests see of it.
#pragma once

#include "formats/image.h"
#include "transport/pack_shading.h"

namespace bakelight::example {

// Radiance = what the picture shows where the ball has the hit's normal × mean radiance of all light.
class NormalShading final : public transport::PackShading {
 public:
  static bool shades(const formats::Pack& pack);
  explicit NormalShading(const formats::Pack& pack);

  transport::LightNeeds needs() const override { return {1}; }
  void setLight(std::span<const transport::Float3> distant, std::span<const transport::Float3> near) override;
  void setView(const transport::ViewPoint& view) override { eye_ = view.eye; }
  // The normal is interpolated and looked up for each hit, linearly between texels.
  void radianceAt(std::span<const transport::SurfaceHit> hits,
                  std::span<transport::Float3> radiance) const override;

 private:
  formats::TriangleMesh mesh_;
  formats::Image picture_;
  transport::Float3 mean_radiance_ = {0, 0, 0};
  transport::Vec3 eye_ = transport::Vec3::Zero();
};

transport::ShadingTechnique normalShading();

}  // namespace bakelight::example
