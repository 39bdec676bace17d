#include "compression/coded_sums.h"

#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "compression/shared_sums.h"
#include "compression/tolerance.h"
#include "formats/sum_grammar_code.h"

namespace bakelight::compression {

CompressedTransfer exactSums(const formats::PixelCodes& codes) {
  formats::SumGrammar grammar = compress(codes);
  const std::uint64_t bytes = formats::encodeSums(grammar).byteCount(),
                      operations = operationsOf(grammar).counted;
  return sharedSums(std::move(grammar), bytes, operations);
}

CompressedTransfer sumsWithin(std::uint64_t budget, const formats::PixelCodes& codes) {
  constexpr double kUsualTolerance = 0.15;
  constexpr int kSteps = 8;
  std::optional<CompressedTransfer> best;
  double best_tolerance = 1;
  solveForBytes(
      [&](double tolerance) {
        CompressedTransfer sums = exactSums(withinTolerance(codes, tolerance).rows.view());
        const std::uint64_t bytes = sums.bytes;
        if (bytes <= budget && (!best || bytes >= best->bytes))
          best = std::move(sums), best_tolerance = tolerance;
        return bytes;
      },
      budget, kUsualTolerance, kSteps);
  best->name = "sums_within";
  std::array<char, 16> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), best_tolerance, std::chars_format::general, 2);
  best->parameters = "tolerance " + std::string(text.data(), end.ptr);
  return std::move(*best);
}

}  // namespace bakelight::compression
