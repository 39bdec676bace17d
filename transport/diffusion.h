// Diffuse subsurface reflectance R_d(r): radiosity at a distance r in a plane, per unit of power that enters a half space of a
// scattering medium in one point; the same R_d serves curved surfaces by straight distances (Jensen, Marschner, Levoy and
// Hanrahan 2001, "A Practical Model for Subsurface Light Transport"). One color at a time.
#pragma once

#include <span>
#include <vector>

#include "formats/medium.h"

namespace bakelight::transport {

// The dipole of Jensen et al.; the better one of d'Eon 2012 ("A Better Dipole": Grosjean's diffusion, exitance of flux and fluence);
// Burley 2015 ("Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering").
using formats::DiffusionModel;

// Per unit of length.
struct ScatteringCoefficients {
  double reduced_scattering = 1;  // σs′ ≥ 0
  double absorption = 0;          // σa ≥ 0; not both 0
  double relative_ior = 1.3;      // η of inside to outside, ≥ 1

  double extinction() const { return reduced_scattering + absorption; }  // σt′
  double albedo() const { return reduced_scattering / extinction(); }    // α′
};

// Fresnel reflectance of unpolarised light that meets a boundary at that cosine, 0–1; `relative_ior`: of the side beyond it to this
// one. Below 1 it is total from the critical angle on.
double fresnelReflectance(double cosine, double relative_ior);
// Schlick 1994, of transmittance: what enters from outside.
double schlickTransmittance(double cosine, double relative_ior);

// Zonal factors of max(n·s, 0) times that: what enters, as transport::clampedCosineFactors is what falls on. `order` entries.
std::vector<double> enteringCosineFactors(int order, double relative_ior);

// ∫ F(μ) μ dμ and ∫ F(μ) μ² dμ over μ = 0–1, by quadrature to some 1e-9. Twice the first is the diffuse reflectance F_dr.
struct FresnelMoments {
  double first = 0, second = 0;
};
FresnelMoments fresnelMoments(double relative_ior);

// All models are sums of two kinds of sources, a depth z below the surface, at d = √(r² + z²):
//   flux      z (σd + 1) e^{−σd} / d³
//   fluence   e^{−σd} / d
// so each figure below has a closed form. Figures stay right to rounding for σa = 0 (the total is then 1, but what lies beyond R falls
// only as 1/R) and for media of any scale. In units of 1/length² where they are per area.
class DiffuseReflectance {
 public:
  // Throws std::invalid_argument for coefficients that are negative, not finite, or do not scatter at all, η < 1 or > 3.
  DiffuseReflectance(DiffusionModel model, const ScatteringCoefficients& coefficients);

  // At distance r ≥ 0. Infinite at 0 for normalized diffusion.
  double operator()(double distance) const;
  // ∫ R_d over the plane: share of all entering power that leaves, 0–1. α′/2 (1 + e^{−4A/3 s}) e^{−s}, s = √(3(1 − α′)), of the dipole.
  double total() const { return frequencyResponse(0); }
  // ∫ R_d over a disk of that radius.
  double enclosed(double radius) const;
  // ∫ R_d along a line at that distance > 0: response to a line of light, per length.
  double lineSpread(double distance) const;
  // Hankel transform: what is left of the contrast of a sinusoid of that wavenumber (2π / wavelength).
  double frequencyResponse(double wavenumber) const;
  // What of R_d samples on a square grid of that spacing can carry: their sum over the grid, times the square of the spacing, has
  // frequencyResponse() up to half the grid's Nyquist frequency; beyond, it falls to nothing at three halves. Where R_d is that smooth
  // itself, it is R_d; where all light stays within a texel, it is nearly total() in one sample. By quadrature, good to some 1e-6 of its
  // value at 0 for distances up to 8 spacings.
  double bandLimited(double distance, double spacing) const;
  // Where R_d has fallen to nothing against its total: the radius that encloses all but `share` of it. Infinite if absorption is 0 and
  // `share` is out of reach in numbers.
  double radiusFor(double share) const;

 private:
  struct Source {
    double depth, flux, fluence;
  };
  struct Group {  // of equal attenuation
    double attenuation;
    std::vector<Source> sources;
    double fluence = 0;  // Σ of the sources', in the plane's far field: 0 where they cancel exactly
  };
  std::vector<Group> groups_;
};

// DiffuseReflectance::bandLimited at the same distances, in spacings, of many media: what does not depend on these once.
class BandLimit {
 public:
  explicit BandLimit(std::span<const double> distances);
  // Times the square of the spacing.
  std::vector<double> operator()(const DiffuseReflectance& reflectance, double spacing) const;

 private:
  std::vector<double> wavenumbers_;  // times the spacing
  std::vector<double> weights_;      // distances × wavenumbers
};

// The medium of that σt′ whose total() is `reflectance`: α′ by bisection ("albedo inversion"; total() rises with it from 0 to 1, whatever σt′ is). Of 1 and more
// nothing is absorbed. Throws std::invalid_argument unless `reflectance` is above 0, and as DiffuseReflectance.
ScatteringCoefficients coefficientsOfReflectance(DiffusionModel model, double reflectance, double extinction,
                                                 double relative_ior);

}  // namespace bakelight::transport
