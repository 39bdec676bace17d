// How a transfer matrix in a pixel basis might be stored: exactly, within a bound, and by other methods at as many bytes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/report/evaluation.h"
#include "tools/report/plan.h"

namespace bakelight::report {

// Shares of the bytes of the exact sums.
inline constexpr double kStorageShares[] = {1, 0.5};

// Whether the pack's transfer is such a matrix, and exact.
bool hasStorage(const formats::Pack& pack);

// `advanced` is called after each method. Cost: minutes for a million rows, most of it for the rivals. Throws std::invalid_argument for a pack that has none.
StorageFigures measureStorage(const formats::Pack& pack, const Plan& plan, Renderer& renderer,
                              const std::vector<Reference>& truth, const std::function<void()>& advanced);

}  // namespace bakelight::report
