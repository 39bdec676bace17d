// A clear sky with its sun: Preetham, Shirley & Smits 1999, "A Practical Analytic Model for Daylight".
#pragma once

#include <array>

#include "formats/light_rig.h"
#include "transport/lights.h"

namespace bakelight::transport {

// Linear sRGB whose luminance is in kcd/m² (times the light's intensity): a clear zenith is a few units, the
// sun about 10⁶. Where the sun stands below the horizon the model ends: everything is dark. Colours outside
// sRGB are clamped. Finite and not negative for all values that formats::readLightRig lets pass.
class Sky {
 public:
  using Rgb = Eigen::Array3d;

  explicit Sky(const formats::SkyLight& light);

  // Sky above the horizon, ground below it; without the sun's disk.
  Rgb radiance(const Vec3& direction) const;

  const Vec3& sunDirection() const { return sun_direction_; }
  // Of the disk of 0.53° across, behind the air: table of the sun's spectral radiance × transmittance of air,
  // aerosols and ozone (the paper's appendix; mixed gases and water vapour absorb where the eye sees little).
  // Zero without sun.
  const Rgb& sunRadiance() const { return sun_radiance_; }
  // What a Lambertian plane under this sky and sun sends back.
  const Rgb& groundRadiance() const { return ground_radiance_; }

 private:
  Rgb skyRadiance(double zenith_cosine, double sun_cosine) const;
  Rgb skyIrradiance() const;

  // One of Y, x, y: zenith value and the five parameters A … E of Perez's luminance distribution.
  struct Distribution {
    double zenith = 0;
    std::array<double, 5> shape{};
  };
  double evaluate(const Distribution& distribution, double zenith_cosine, double sun_cosine) const;

  bool is_day_;
  double intensity_;
  Vec3 sun_direction_;
  double sun_zenith_rad_;
  std::array<Distribution, 3> distributions_;
  Rgb sun_radiance_ = Rgb::Zero(), ground_radiance_ = Rgb::Zero();
};

inline constexpr double kSunHalfAngle_rad = 0.265 / 57.29577951308232;

// The sky by quadrature (to about 1e-5 of its largest coefficient), ground and sun in closed form.
ShLight skyLight(const Sky& sky, int order);

}  // namespace bakelight::transport
