// A BTF as a `.btf` file, and what that costs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "formats/btf.h"
#include "formats/btf_writer.h"

namespace bakelight::btf {

struct RewritingOptions {
  formats::BtfWrittenLayout layout = formats::BtfWrittenLayout::kFactorized;
  formats::BtfColorModel model = formats::BtfColorModel::kYuv;
  int rank = 32;
  formats::BtfPrecision precision = formats::BtfPrecision::kHalf;
};

struct RewritingFigures {
  std::uint64_t bytes = 0;
  // √(Σ (written − given)² / Σ given²) of red, green and blue, by reading the file again.
  double relative_error = 0;
  // Factorised: of each channel of the colour model.
  std::vector<std::size_t> ranks;
  std::vector<double> channel_errors;
  std::size_t negative_values = 0;
};

// Throws as factorize, the writers and decoding do.
RewritingFigures rewrite(const formats::Btf& btf, const std::filesystem::path& path,
                         const RewritingOptions& options);

}  // namespace bakelight::btf
