// Figures of tensors, and the energy of transfer vectors by SH band.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/tensors.h"
#include "tools/inspect/moments.h"

namespace bakelight::inspect {

// Element `index` as a double (64-bit integers past 2^53 are rounded).
double elementOf(const formats::Tensor& tensor, std::uint64_t index);

Moments measureTensor(const formats::Tensor& tensor);

// Σ_m T_lm² of each band l, averaged over the rows. By Parseval, the bands add up to the mean of ∫T(s)² ds.
// `vectors` is n × order², row-major.
std::vector<double> bandEnergies(std::span<const float> vectors, int order);

// The order that a table of so many columns has, or 0 if that is no square.
int orderOfColumns(std::uint64_t columns);

}  // namespace bakelight::inspect
