// Isotropic BRDFs, projected into spherical harmonics for glossy transfer (Kautz, Sloan & Snyder 2002; Sloan,
// Kautz & Snyder 2002, section 5).
//
// Directions are in the local frame, normal along +z, and point away from the surface.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "formats/material.h"
#include "formats/tensors.h"
#include "transport/microfacet.h"
#include "transport/vector_types.h"

namespace bakelight::brdf {

using transport::Vec3;

// Red, green and blue reflectance per steradian for light from `incident` leaving towards `outgoing`, both
// with z ≥ 0. Isotropic: unchanged when both turn about z, or are mirrored. Called from several threads at
// once.
using Brdf = std::function<Vec3(const Vec3& incident, const Vec3& outgoing)>;

// ρ/π.
Brdf lambert(const Vec3& diffuse_color);
// Lambert plus ρ_s (n + 2)/2π · max(cos α, 0)^n around the mirror direction: reciprocal and energy-conserving
// where ρ_d + ρ_s ≤ 1 (Lafortune & Willems 1994). Exponent ≥ 0.
Brdf phong(const Vec3& diffuse_color, const Vec3& specular_color, double exponent);
// Microfacets. Not a mirror.
Brdf ggx(const transport::Microfacets& facets);
// What a material reflects besides its diffuse part, as `reference` traces it: nothing; Phong's lobe around
// the mirror direction (which is not reciprocal: what it is divided by is the cosine of light); GGX by
// microfacets of a roughness of at least kSmallestRoughness, from which up to ten bands do not tell a mirror.
// Throws std::invalid_argument for a table, which is projected already.
inline constexpr double kSmallestRoughness = 0.05;
Brdf reflection(const formats::Reflection& reflection);

struct Projection {
  formats::BrdfTable table;
  // What of a uniform sky of 1 leaves towards the eye, a row of the table:
  // ∫ f cos θ ds. By reciprocity also the albedo for light from there: above 1, the BRDF makes energy.
  std::vector<Vec3> albedo;
  double residual =
      0;  // largest change of a coefficient at the last refinement, over the largest coefficient
};

// Row a: the eye at cos θ = a / (angles − 1), azimuth 0; orders 1–10, angles ≥ 2. Gauss–Legendre on panels
// that shrink towards the mirror direction, refined until no coefficient moves by more than `tolerance` of
// the largest one, or for the last time. Throws std::invalid_argument for a BRDF that is not finite. Cost:
// angles × some 10,000 to 300,000 evaluations, on all TBB threads.
Projection project(const Brdf& brdf, int order, int angles, double tolerance = 1e-6);

// The file that `pack` reads (docs/FORMATS.md): tables of one order, by the name of their material; "" is that of
// all others.
formats::TensorFile tensorFile(const std::map<std::string, formats::BrdfTable>& tables);

}  // namespace bakelight::brdf
