// Microfacet reflection: GGX-distributed mirrors with height-correlated Smith masking and shadowing (Walter
// et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; Heitz 2014, "Understanding the
// Masking-Shadowing Function"), alpha = roughness².
//
// Directions are unit vectors in the local frame, normal along +z, and point away from the surface.
#pragma once

#include <vector>

#include "transport/vector_types.h"

namespace bakelight::transport {

class Microfacets {
 public:
  // `fresnel`: a facet's reflectance rises from `specular_color` at normal incidence to 1 at grazing angles
  // by Schlick's term (1994); without, it is that colour. `multiple_scattering`: what facets would mask is
  // reflected from facet to facet until it leaves, as the separable lobe of Kulla & Conty 2017 ("Revisiting
  // Physically Based Shading at Imageworks"), so that white facets reflect all light; without, that light is
  // lost. Roughness 0–1, below kMirrorRoughness a mirror. Cost: with multiple scattering some million
  // evaluations.
  Microfacets(const Vec3& specular_color, double roughness, bool fresnel, bool multiple_scattering);

  static constexpr double kMirrorRoughness = 1e-6;
  bool isMirror() const { return mirror_; }

  // Of a facet, by the cosine between its normal and light or eye.
  Vec3 facetReflectance(double cosine) const;

  // Per steradian, without the cosine of light; zero where either is below the surface. Reciprocal. Not for a
  // mirror. brdf() is the sum of the other two.
  Vec3 brdf(const Vec3& incident, const Vec3& outgoing) const;
  Vec3 singleScattering(const Vec3& incident, const Vec3& outgoing) const;
  Vec3 multipleScattering(double cosine_in, double cosine_out) const;

  // Where light comes from that a facet mirrors towards `outgoing` (z ≥ 0), by the distribution of normals
  // that are visible from there (Heitz 2018, "Sampling the GGX Distribution of Visible Normals"): the image
  // of a point of the unit square. May lie below the surface.
  Vec3 sampleIncident(const Vec3& outgoing, double u, double v) const;
  double densityPerSr(const Vec3& incident, const Vec3& outgoing) const;

  // Share of light from (or towards) this angle that white facets reflect without multiple scattering, and
  // the luminance-free colour by which multiple scattering returns the rest. With multiple scattering only.
  double singleAlbedo(double cosine) const;
  const Vec3& multipleColor() const { return multiple_color_; }
  bool scattersMultiply() const { return !albedo_.empty(); }

 private:
  double distribution(const Vec3& half) const;  // D
  double slopeTerm(double cosine) const;        // √(α² + (1 − α²) cos²)
  double integratedAlbedo(double cosine) const;

  Vec3 specular_color_;
  double alpha_;
  bool fresnel_, mirror_;
  std::vector<double> albedo_;  // singleAlbedo at cosines (i / (n − 1))²; empty without multiple scattering
  double mean_albedo_ = 1;      // 2 ∫ singleAlbedo μ dμ
  Vec3 multiple_color_ = Vec3::Zero();
};

}  // namespace bakelight::transport
