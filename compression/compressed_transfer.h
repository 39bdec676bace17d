// A transfer matrix in a pixel basis as somebody stores it, exactly or not: the one form in which methods are compared.
//
// All are allowed the same last step: their tables are quantised as they see fit and entropy-coded by the same coder (formats/symbol_code.h),
// and `bytes` is what comes out. Vertices' frames, which all need, are not counted.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "formats/pixel_transfer.h"
#include "formats/sum_grammar.h"
#include "transport/sum_product.h"

namespace bakelight::compression {

using transport::Radiance4;

struct CompressedTransfer {
  std::string name;        // "sums", "haar", …
  std::string parameters;  // for people: "24 clusters × 6 components"
  std::uint64_t bytes = 0;
  // Floating-point operations of one channel of a product: 2 for a term that is multiplied and added, 1 for one that is added.
  std::uint64_t operations = 0;
  std::size_t value_count = 0;
  // `light` as transport::multiply has it, radiance × solid angle a texel; value_count values. On all TBB threads, the same whatever
  // their number.
  std::function<void(std::span<const Radiance4> light, std::span<Radiance4> values)> multiply;
  // Where each row's value is, kNoValue for rows that are 0; empty: value r is row r's.
  std::vector<std::uint32_t> places;

  // L* of all rows.
  std::vector<Radiance4> incident(std::span<const Radiance4> light) const;
};

// Compressed sparse rows. `codes` must outlive it. Bytes: of three streams, lengths of rows, steps between columns and codes.
CompressedTransfer plainRows(const formats::PixelCodes& codes);

// What compress() of shared_sums.h made; `bytes` of its file, `operations` as it counts them.
CompressedTransfer sharedSums(formats::SumGrammar grammar, std::uint64_t bytes, std::uint64_t operations);

// The largest size within the budget, to kBudgetSlack where sizes can be had so finely: `bytes_at` falls as its argument rises from 0 to
// 1, but for little. `guess` is tried first. Throws std::invalid_argument if not even that of 1 fits.
struct Solved {
  double at = 0;
  std::uint64_t bytes = 0;
};
Solved solveForBytes(const std::function<std::uint64_t(double)>& bytes_at, std::uint64_t budget,
                     double guess = 0.5, int most_steps = 24);

// How much of the budget solveForBytes leaves at most where sizes can be had so finely.
inline constexpr double kBudgetSlack = 0.02;

}  // namespace bakelight::compression
