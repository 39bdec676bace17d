// Measured isotropic BRDFs of the MERL database (Matusik, Pfister, Brand & McMillan 2003).
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tools/brdf/brdf.h"

namespace bakelight::brdf {

inline constexpr int kMerlHalfAngles = 90, kMerlDifferenceAngles = 90, kMerlAzimuths = 180;

// From the bytes of a .binary file: three 32-bit sizes (90, 90, 180), then as many doubles for red, for green
// and for blue, over half angle (in steps of its square), difference angle and azimuth of the difference
// (180°, the rest by reciprocity). Values are scaled by 1/1500, 1.15/1500 and 1.66/1500; negative ones, which
// mark what could not be measured, count as 0. Throws Error(kBadInput) naming `file` for another size.
Brdf readMerl(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::brdf
