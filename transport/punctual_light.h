// Punctual lights of a rig (formats/light_rig.h) where they stand, and what they send.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "formats/light_rig.h"
#include "transport/camera.h"
#include "transport/lights.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

struct PlacedPunctualLight {
  using Type = formats::PunctualLight::Type;

  Type type = Type::kPoint;
  Vec3 position = Vec3::Zero();
  Eigen::Array3d intensity = Eigen::Array3d::Ones();  // irradiance at a distance of 1
  // Right-handed: to the right of one who looks along −z, up, and back; unit. `axes.col(2)` is against the direction of a spot or slide.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  double inner = 0, outer = 1;             // spot: 1 − cosine of its half angles
  double half_width = 1, half_height = 1;  // slide: of the picture at a distance of 1
  std::shared_ptr<const formats::Image> image;

  // Radiant intensity into a direction (unit). Spots fade as glTF's do: ((cos θ − cos outer) ÷ (cos inner − cos outer))², held
  // between 0 and 1. A slide's pixels have hard edges.
  Eigen::Array3d intensityTowards(const Vec3& direction) const;
  // Irradiance of what faces the light at `point`: intensity ÷ distance². Nothing at the light itself.
  Eigen::Array3d irradianceFacing(const Vec3& point) const;
};

// In object space, or the world's: positions as in emitterMesh, intensities for the lengths there.
std::vector<PlacedPunctualLight> placedPunctualLights(const formats::LightRig& rig,
                                                      const BoundingSphere& object, double time_s);
void turnAbout(const Vec3& center, const Eigen::Matrix3d& rotation, std::vector<PlacedPunctualLight>& lights);

// `light` and the lights' mean radiance at `center`, for exposure, which goes by the first coefficient: scalar irradiance ÷ 4π, slides
// by the mean of their picture, spots by their intensity in the middle, whether they shine there or not.
ShLight withMeanLight(ShLight light, const std::vector<PlacedPunctualLight>& lights, const Vec3& center);

}  // namespace bakelight::transport
