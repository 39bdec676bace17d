#include "compression/compressed_transfer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "formats/symbol_code.h"

namespace bakelight::compression {

std::vector<Radiance4> CompressedTransfer::incident(std::span<const Radiance4> light) const {
  std::vector<Radiance4> values(value_count, Radiance4::Zero());
  multiply(light, values);
  if (places.empty()) return values;
  std::vector<Radiance4> rows(places.size(), Radiance4::Zero());
  for (std::size_t row = 0; row < rows.size(); ++row)
    if (places[row] != transport::kNoValue) rows[row] = values[places[row]];
  return rows;
}

CompressedTransfer plainRows(const formats::PixelCodes& codes) {
  std::vector<std::uint32_t> lengths, steps, values;
  std::uint64_t whole = 0;
  const int full = codes.subsamples * codes.subsamples;
  for (std::size_t row = 0; row < codes.rowCount(); ++row) {
    const std::uint64_t begin = codes.row_offsets[row], end = codes.row_offsets[row + 1];
    lengths.push_back(static_cast<std::uint32_t>(end - begin));
    for (std::uint64_t i = begin; i < end; ++i) {
      steps.push_back(i == begin ? codes.columns[i] : codes.columns[i] - codes.columns[i - 1] - 1U);
      values.push_back(codes.codes[i] - 1U);
      if (codes.codes[i] == full) ++whole;
    }
  }
  CompressedTransfer rows;
  rows.name = "rows";
  rows.parameters = std::to_string(codes.columns.size()) + " entries";
  for (const auto& stream : {lengths, steps, values}) rows.bytes += formats::encodeSymbols(stream).size();
  rows.operations = 2 * codes.columns.size();
  rows.value_count = codes.rowCount();
  rows.multiply = [codes](std::span<const Radiance4> light, std::span<Radiance4> out) {
    transport::multiply(codes, light, out);
  };
  return rows;
}

CompressedTransfer sharedSums(formats::SumGrammar grammar, std::uint64_t bytes, std::uint64_t operations) {
  const auto kept = std::make_shared<const formats::SumGrammar>(std::move(grammar));
  CompressedTransfer sums;
  sums.name = "sums";
  sums.parameters = std::to_string(kept->sum_parts.size() / 2) + " sums";
  sums.bytes = bytes;
  sums.operations = operations;
  sums.value_count = kept->row_places.size();
  sums.multiply = [kept](std::span<const Radiance4> light, std::span<Radiance4> values) {
    transport::multiply(*kept, light, values);
  };
  sums.places = transport::valuePlaces(*kept);
  return sums;
}

Solved solveForBytes(const std::function<std::uint64_t(double)>& bytes_at, std::uint64_t budget, double guess,
                     int most_steps) {
  // Sizes are nearly exponential in what is solved for: false position on their logarithms, halving where that is slow.
  const auto excess = [&](std::uint64_t bytes) {
    return std::log(static_cast<double>(std::max<std::uint64_t>(bytes, 1)) /
                    ((1 - kBudgetSlack / 2) * static_cast<double>(budget)));
  };
  constexpr double kNearGuess = 0.03;
  Solved best{1, bytes_at(1)};
  if (best.bytes > budget) throw std::invalid_argument("solveForBytes: the budget is too small");
  double low = 0, high = 1, low_excess = std::numeric_limits<double>::quiet_NaN(),
         high_excess = excess(best.bytes);
  for (int step = 0; step < most_steps; ++step) {
    if (static_cast<double>(best.bytes) >= (1 - kBudgetSlack) * static_cast<double>(budget)) break;
    double next = step == 0 ? guess : (low + high) / 2;
    if (step == 1 && !std::isfinite(low_excess)) next = std::max(low, guess - kNearGuess);
    if (step == 1 && std::isfinite(low_excess)) next = std::min(high, guess + kNearGuess);
    if (step > 1 && step % 4 != 0 && std::isfinite(low_excess))
      next = std::clamp(low + (high - low) * low_excess / (low_excess - high_excess), low + (high - low) / 50,
                        high - (high - low) / 50);
    const std::uint64_t bytes = bytes_at(next);
    if (bytes <= budget) {
      high = next;
      high_excess = excess(bytes);
      if (bytes >= best.bytes) best = {next, bytes};
    } else {
      low = next;
      low_excess = excess(bytes);
    }
  }
  return best;
}

}  // namespace bakelight::compression
