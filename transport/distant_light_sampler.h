// Distant light as it is, without spherical harmonics: looked up, and sampled by importance, for Monte Carlo
// integration.
#pragma once

#include <vector>

#include "formats/light_rig.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

using Rgb = Eigen::Array3d;

// All distant lights of a rig, turned into the world; the default light (lights.h) for a rig without any
// light.
//   Lat-long images are constant over each texel, as projectLatLong integrates them, and are sampled by
// luminance × exact solid angle, uniformly within the texel. Disks and the sun are cones, uniform in solid
// angle. Sky with ground, polygons and cube maps are drawn into a lat-long image first. Which of
// these a sample comes from is drawn by power (luminance × solid angle), so a small sun of 10⁶ is met as
// often as its light weighs. Directional lights have no extent and are listed apart.
class DistantLightSampler {
 public:
  // Throws what drawBackdrop and rgbImage throw.
  DistantLightSampler(const formats::LightRig& rig, const Eigen::Matrix3d& world_from_light);

  // What comes from a direction (unit, towards the light): radiance, and how densely sample() visits it. The
  // density is 0 where nothing or less than nothing (a negative texel) shines.
  struct Incident {
    Rgb radiance = Rgb::Zero();
    double density_per_sr = 0;
  };
  Incident towards(const Vec3& direction) const;

  struct Sample {
    Vec3 direction;
    Incident incident;
  };
  // The image of a point of the unit square; keeps its strata together. Not to be called if !isLit().
  Sample sample(double u, double v) const;
  bool isLit() const { return !cumulative_power_.empty() && cumulative_power_.back() > 0; }

  struct Directional {
    Vec3 direction;
    Rgb irradiance;  // on a surface that faces it
  };
  const std::vector<Directional>& directional() const { return directional_; }

 private:
  // Texels of a lat-long image by luminance × solid angle.
  class Texels {
   public:
    // `image` has channels R, G, B.
    Texels(formats::Image image, double intensity, const Eigen::Matrix3d& world_from_image);
    double power() const { return power_; }
    Incident towards(const Vec3& direction) const;
    Sample sample(double u, double v) const;

   private:
    Incident at(int x, int y) const;
    double sineAbove(int y) const;

    formats::Image image_;
    Eigen::Matrix3d world_from_image_;
    double power_ = 0, intensity_;
    // Cumulative probabilities: of rows (height + 1), and of the texels of each row (height × (width + 1)).
    std::vector<double> rows_, columns_;
    std::vector<double> solid_angle_sr_;  // of a texel in each row
  };

  class Cone {
   public:
    Cone(const Vec3& axis, double half_angle_rad, const Rgb& radiance);
    double power() const;
    Incident towards(const Vec3& direction) const;
    Sample sample(double u, double v) const;

   private:
    Vec3 axis_, right_, up_;
    double half_chord_squared_;  // sin²(half angle / 2): (1 − cosine) / 2 at the rim, without cancellation
    Rgb radiance_;
  };

  struct Collector;
  double shareOf(std::size_t source) const;

  std::vector<Texels> texels_;
  std::vector<Cone> cones_;
  std::vector<Directional> directional_;
  std::vector<double> cumulative_power_;  // of texels_, then cones_; from 0 up to 1
};

}  // namespace bakelight::transport
