// Measured anisotropic BRDFs of the UTIA database (Filip & Vávra 2014, "Template-Based Sampling of Anisotropic BRDFs").
#pragma once

#include "tools/brdf/measured.h"

namespace bakelight::brdf {

inline constexpr int kUtiaPolarAngles = 6, kUtiaAzimuths = 48;  // in steps of 15° and 7.5°

// From the bytes of a .bin file: doubles, planes of red, green and blue, each (light's polar angle, light's azimuth) ×
// (view's polar angle, view's azimuth). Values are per steradian, without the cosine of light; negative ones count as 0
// and are noted. Averaged over turns about the normal and over mirror images, then interpolated linearly in
// both polar angles and the difference of azimuths; beyond 75° as at 75°. Throws Error(kBadInput) naming `file`
// for another size or a value that is not finite.
MeasuredBrdf readUtia(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::brdf
