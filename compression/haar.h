// The two-dimensional Haar wavelets of a cube map's faces (nonstandard decomposition, orthonormal): what Ng, Ramamoorthi & Hanrahan 2003
// ("All-Frequency Shadows Using Non-linear Wavelet Lighting Approximation") represent light and transfer in.
//
// A face of side² texels has as many coefficients, in Mallat's order: the three details of the pair of squares (x, y) of level l, whose
// side is `half` squares, are at (x + half, y), (x, y + half), (x + half, y + half); the mean (× side) is at (0, 0).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/pixel_transfer.h"
#include "transport/sum_product.h"

namespace bakelight::compression {

using transport::Radiance4;

// Faces of other sides have no such wavelets.
bool hasHaar(int cube_side);

// Of light: 6 · side² values, in place. Throws std::invalid_argument for a side that is no power of two.
void forwardHaar(int cube_side, std::span<Radiance4> faces);
void inverseHaar(int cube_side, std::span<Radiance4> faces);

// The solid angle that each wavelet's support covers, steradians.
std::vector<float> haarAreas(int cube_side);

// Rows of a matrix in the basis of light's wavelets: ascending indices.
struct WaveletRows {
  int cube_side = 32;
  std::vector<std::uint64_t> offsets = {0};
  std::vector<std::uint16_t> indices;
  std::vector<float> values;

  std::size_t rowCount() const { return offsets.size() - 1; }
};

// All coefficients that are not 0 of codes ÷ subsamples². Cost: linear in the entries; some 8 bytes a coefficient.
WaveletRows haarRows(const formats::PixelCodes& codes);

}  // namespace bakelight::compression
