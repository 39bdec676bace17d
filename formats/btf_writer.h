// Writes `.btf` files of the University of Bonn (docs/BTF.md).
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "formats/btf.h"
#include "formats/btf_color.h"
#include "formats/words.h"

namespace bakelight::formats {

// A channel's values are Σ_k directions[(view · lights + light) · rank + k] · texels[texel · rank + k].
struct BtfFactors {
  std::size_t rank = 0;
  std::vector<float> singular_values, directions, texels;
};

enum class BtfPrecision { kHalf, kFloat };
inline constexpr Word<BtfPrecision> kBtfPrecisions[] = {{"half", BtfPrecision::kHalf},
                                                        {"float", BtfPrecision::kFloat}};

enum class BtfWrittenLayout { kFactorized, kRaw };
inline constexpr Word<BtfWrittenLayout> kBtfWrittenLayouts[] = {{"factorized", BtfWrittenLayout::kFactorized},
                                                                {"raw", BtfWrittenLayout::kRaw}};

// Those that can be written.
inline constexpr Word<BtfColorModel> kBtfWrittenModels[] = {{"yuv", BtfColorModel::kYuv},
                                                            {"rgb", BtfColorModel::kRgb},
                                                            {"ycocg", BtfColorModel::kYCoCg},
                                                            {"log_yuv", BtfColorModel::kLogYRelativeUv},
                                                            {"log_rgb", BtfColorModel::kLogRgb}};

// Decorrelated full-matrix factorisation ("!DFMF08FCR"), three channels that may have different ranks, without rotations.
// Atomic; written as it comes. Throws Error(kBadInput) naming the channel if a value does not fit a half, std::logic_error
// for factors of other sizes than `info` says.
void writeFactorizedBtf(const std::filesystem::path& path, const BtfInfo& info, BtfColorModel model,
                        const std::vector<BtfFactors>& channels, BtfPrecision precision);

// All values as halves ("!BDIF06R2!", uncompressed). Atomic. Throws Error(kBadInput) naming view, light and texel if a
// value does not fit a half, or if pictures are missing.
void writeRawBtf(const std::filesystem::path& path, const Btf& btf);

}  // namespace bakelight::formats
