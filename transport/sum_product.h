// The product of a transfer matrix in a pixel basis with light.
#pragma once

#include <cstdint>
#include <Eigen/Core>
#include <span>
#include <vector>

#include "formats/pixel_transfer.h"
#include "formats/sum_grammar.h"

namespace bakelight::transport {

// RGB and a spare value: a row's light, or a texel's, in one register.
using Radiance4 = Eigen::Vector4f;

// Up to so many subsamples the light is scaled by all codes once, instead of by each leaf.
inline constexpr int kMostTabledSubsamples = 4;

// Value r of the result belongs to row row_places[r]. `light` has a value a texel, radiance × solid angle; sums are scaled by
// 1 / subsamples². On all TBB threads, the same whatever their number. Throws std::invalid_argument for sizes that do not fit.
void multiply(const formats::SumGrammar& grammar, std::span<const Radiance4> light,
              std::span<Radiance4> values);

// Where each row of the matrix is among the values; kNoValue for rows without an entry.
inline constexpr std::uint32_t kNoValue = ~std::uint32_t{0};
std::vector<std::uint32_t> valuePlaces(const formats::SumGrammar& grammar);

// The matrix itself with the light: value r is row r's.
void multiply(const formats::PixelCodes& codes, std::span<const Radiance4> light,
              std::span<Radiance4> values);

}  // namespace bakelight::transport
