// A BTF as a sum of few products, for files that are a hundred times smaller (Müller, Meseth & Klein 2003).
#pragma once

#include <vector>

#include "formats/btf.h"
#include "formats/btf_writer.h"

namespace bakelight::transport {

struct BtfFactorization {
  std::vector<formats::BtfFactors> channels;
  // Of each channel, as the model has it: √(Σ(product − value)² / Σ value²), from what the singular values leave.
  std::vector<double> relative_errors;
  std::size_t negative_values = 0;  // that a logarithm took for 0
};

// Truncated singular value decomposition of the matrix of pairs of directions × texels, of each channel of the model.
// Randomised (Halko, Martinsson & Tropp 2011: 10 more columns than `rank`, two power iterations), with a fixed
// seed; components below rounding are left out. Decodes the BTF six times and holds 3 · (rank + 10) numbers
// a pair of directions and a texel. The same on any number of threads. Throws Error(kBadInput) if pictures are
// missing.
BtfFactorization factorize(const formats::Btf& btf, formats::BtfColorModel model, int rank);

// √(Σ (btf − expected)² / Σ expected²) of red, green and blue of two BTFs of the same shape. Decodes each once.
double relativeError(const formats::Btf& btf, const formats::Btf& expected);

}  // namespace bakelight::transport
