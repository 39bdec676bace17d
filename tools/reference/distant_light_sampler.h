// Distant light as it is, without spherical harmonics: looked up, and sampled by importance, for Monte Carlo
// integration.
#pragma once

#include <memory>
#include <vector>

#include "formats/light_rig.h"
#include "transport/vector_types.h"

namespace bakelight::reference {

using transport::Float3, transport::Vec3;

using Rgb = Eigen::Array3d;

// All distant lights of a rig, turned into the world; the default light (lights.h) for a rig without any
// light.
//   Lat-long images are constant over each texel, as projectLatLong integrates them: a texel is drawn by
// luminance × exact solid angle, a direction uniformly within it. Disks and the sun are cones, uniform in
// solid angle. Sky with ground, polygons and cube maps are drawn into a lat-long image first.
//   What lies behind a surface is not worth sampling, so images are cut into blocks, and for each of some
// hundred directions of a normal these and the cones have a weight: power (luminance × solid angle) × cosine,
// taken over all normals of that cell and all directions of the block. A light that any of these normals can
// see has a weight above zero, so a small sun of 10⁶ is met as often as its light counts. Directional lights
// have no extent and are listed apart.
class DistantLightSampler {
 public:
  // Throws what drawBackdrop and rgbImage throw. Cost: some tens of milliseconds an image.
  DistantLightSampler(const formats::LightRig& rig, const Eigen::Matrix3d& world_from_light);
  ~DistantLightSampler();

  Rgb radiance(const Vec3& direction) const;

  // What comes from a direction (unit, towards the light): radiance, and how densely sample() visits it for
  // this normal. The density is 0 where nothing or less than nothing (a negative texel) shines.
  struct Incident {
    Rgb radiance = Rgb::Zero();
    double density_per_sr = 0;
  };
  Incident towards(const Vec3& direction, const Vec3& normal) const;

  struct Sample {
    Vec3 direction = Vec3::UnitY();
    Incident incident;  // of density 0 if no light is above the surface
  };
  // The image of a point of the unit square; keeps its strata together.
  Sample sample(const Vec3& normal, double u, double v) const;

  struct Directional {
    Vec3 direction;
    Rgb irradiance;  // on a surface that faces it
  };
  const std::vector<Directional>& directional() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::reference
