// Glossy reflection of transferred radiance (Sloan et al. 2002, section 5; Kautz et al. 2002).
//
// A vertex's transferred radiance L' (row_order² coefficients, local frame) leaves towards the eye as
//   L_o = Σ_i row_i(eye) · L'_i,
// with one row for the lobes around the reflection direction (tinted by the specular colour) and three for a
// projected BRDF table.
#pragma once

#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "transport/sh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// Factors g_l by which a normalised lobe around the reflection direction scales band l; g_0 = 1, so a lobe
// returns a constant radiance unchanged. `order` values. Phong: (exponent + 1)/2π · cos^exponent over the
// hemisphere around the reflection direction; closed form by recurrence.
std::vector<double> phongKernel(int order, double exponent);
// GGX with alpha = roughness²: D(h) of the half angle × clamped cosine, seen from above (as split-sum
// prefiltering does), normalised. Stable from a mirror (roughness 0: all ones) to 1.
std::vector<double> ggxKernel(int order, double roughness);

// row_i = g_l y_i(reflection), reflection = (−x, −y, |z|) of the unit direction to the eye in the local
// frame. Both sides of the surface reflect alike.
void lobeRow(std::span<const double> kernel, const Vec3& local_eye, std::span<double> row);

// Three rows (RGB) of row_order² from a table: linear between the two nearest angles (|z| of the eye), turned
// about z by the eye's azimuth. The table's further bands are left out.
void tableRows(const formats::BrdfTable& table, const Vec3& local_eye, int row_order,
               std::span<double> red_green_blue);

}  // namespace bakelight::transport
