// Measured BRDFs of the RGL database, as Mitsuba reads them (Dupuy & Jakob 2018, "An Adaptive Parameterization for Efficient
// Material Acquisition and Rendering").
#pragma once

#include "tools/brdf/measured.h"

namespace bakelight::brdf {

// From the bytes of a .bsdf file ("tensor_file", version 1.0): values over a warp that follows the visible normals. The
// direction that the file calls incident is the eye's here, which reciprocity allows: what the file holds has
// the other's cosine in it, which stays where light comes from. Spectra become linear sRGB under equal energy, by the
// CIE 1931 observer. Anisotropic ones (more than two azimuths, all around) are averaged over 16 turns about the normal,
// and noted. Throws Error(kBadInput) naming `file` and field for what is missing, has another shape or type, lies outside
// of the file, is not finite, or covers a part of the azimuths only.
MeasuredBrdf readTensorBsdf(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::brdf
