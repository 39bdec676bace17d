#include "compression/haar_rows.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <limits>
#include <memory>

#include "compression/quantized.h"
#include "formats/symbol_code.h"

namespace bakelight::compression {
namespace {

constexpr std::size_t kRowsAtOnce = 4096;

// Kept coefficients of rows: multiples of a step.
struct KeptRows {
  int cube_side = 32;
  float step = 1;
  std::vector<std::uint64_t> offsets = {0};
  std::vector<std::uint16_t> indices;
  std::vector<std::int16_t> multiples;

  std::uint64_t bytes() const {
    std::vector<std::uint32_t> lengths, steps, values;
    lengths.reserve(offsets.size()), steps.reserve(indices.size()), values.reserve(indices.size());
    for (std::size_t row = 0; row + 1 < offsets.size(); ++row) {
      lengths.push_back(static_cast<std::uint32_t>(offsets[row + 1] - offsets[row]));
      for (std::uint64_t i = offsets[row]; i < offsets[row + 1]; ++i) {
        steps.push_back(i == offsets[row] ? indices[i] : indices[i] - indices[i - 1] - 1U);
        values.push_back(formats::symbolOf(multiples[i]));
      }
    }
    std::uint64_t sum = 0;
    for (const auto& stream : {lengths, steps, values}) sum += formats::encodeSymbols(stream).size();
    return sum;
  }
};

KeptRows kept(const WaveletRows& rows, std::span<const float> weights, const Quantizer& quantizer) {
  KeptRows result;
  result.cube_side = rows.cube_side;
  result.step = quantizer.step;
  result.offsets.reserve(rows.offsets.size());
  for (std::size_t row = 0; row < rows.rowCount(); ++row) {
    for (std::uint64_t i = rows.offsets[row]; i < rows.offsets[row + 1]; ++i)
      if (const std::int32_t multiple = quantizer.quantized(rows.values[i], weights[rows.indices[i]]);
          multiple != 0) {
        result.indices.push_back(rows.indices[i]);
        result.multiples.push_back(static_cast<std::int16_t>(multiple));
      }
    result.offsets.push_back(result.indices.size());
  }
  return result;
}

// Σ (weight · difference)².
double squaredError(const WaveletRows& rows, std::span<const float> weights, const Quantizer& quantizer) {
  double sum = 0;
  for (std::size_t i = 0; i < rows.values.size(); ++i) {
    const double weight = weights[rows.indices[i]];
    const double difference =
        rows.values[i] - quantizer.value(quantizer.quantized(rows.values[i], weights[rows.indices[i]]));
    sum += weight * weight * difference * difference;
  }
  return sum;
}

void multiply(const KeptRows& rows, std::span<const Radiance4> light, std::span<Radiance4> values) {
  std::vector<Radiance4> transformed(light.begin(), light.end());
  forwardHaar(rows.cube_side, transformed);
  for (Radiance4& value : transformed) value *= rows.step;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows.offsets.size() - 1, kRowsAtOnce),
                    [&](const auto& range) {
                      for (std::size_t row = range.begin(); row < range.end(); ++row) {
                        Radiance4 sum = Radiance4::Zero();
                        for (std::uint64_t i = rows.offsets[row]; i < rows.offsets[row + 1]; ++i)
                          sum += transformed[rows.indices[i]] * static_cast<float>(rows.multiples[i]);
                        values[row] = sum;
                      }
                    });
}

// Every kSampled-th of pieces of rows, from which the quantiser is chosen.
constexpr std::size_t kSampled = 8, kPieceRows = 512;

WaveletRows sampleOf(const WaveletRows& rows) {
  if (rows.rowCount() < 4 * kSampled * kPieceRows) return rows;
  WaveletRows sample;
  sample.cube_side = rows.cube_side;
  for (std::size_t row = 0; row < rows.rowCount(); ++row) {
    if (row / kPieceRows % kSampled != 0) continue;
    for (std::uint64_t i = rows.offsets[row]; i < rows.offsets[row + 1]; ++i) {
      sample.indices.push_back(rows.indices[i]);
      sample.values.push_back(rows.values[i]);
    }
    sample.offsets.push_back(sample.indices.size());
  }
  return sample;
}

struct Choice {
  int bits = 0;
  double position = 0.5;  // of the threshold
  Quantizer quantizer;
};

class Solver {
 public:
  Solver(const WaveletRows& rows, std::span<const float> weights) : rows_(rows), weights_(weights) {
    for (std::size_t i = 0; i < rows.values.size(); ++i) {
      const float magnitude = std::abs(rows.values[i]);
      largest_ = std::max(largest_, magnitude);
      largest_weighted_ = std::max(largest_weighted_, magnitude * weights[rows.indices[i]]);
    }
  }

  Choice within(std::uint64_t budget, const WaveletRows& rows, int bits, double guess) const {
    const auto at = [&](double position) {
      return Quantizer::of(largest_, bits, thresholdAt(position, largest_weighted_));
    };
    const Solved solved = solveForBytes(
        [&](double position) { return kept(rows, weights_, at(position)).bytes(); }, budget, guess);
    return {bits, solved.at, at(solved.at)};
  }

  Choice within(std::uint64_t budget) const {
    const WaveletRows sample = sampleOf(rows_);
    const double share = static_cast<double>(sample.rowCount()) /
                         static_cast<double>(std::max<std::size_t>(rows_.rowCount(), 1));
    Choice best;
    double least = std::numeric_limits<double>::infinity();
    for (const int bits : kQuantizerBits) {
      const Choice choice = within(static_cast<std::uint64_t>(share * static_cast<double>(budget)), sample,
                                   bits, best.position);
      const double error = squaredError(sample, weights_, choice.quantizer);
      if (error < least) least = error, best = choice;
    }
    return within(budget, rows_, best.bits, best.position);
  }

 private:
  const WaveletRows& rows_;
  std::span<const float> weights_;
  float largest_ = std::numeric_limits<float>::min(), largest_weighted_ = 0;
};

}  // namespace

CompressedTransfer haarWithin(std::uint64_t budget, const WaveletRows& rows, Selection selection) {
  std::vector<float> weights = haarAreas(rows.cube_side);
  if (selection == Selection::kMagnitude) std::fill(weights.begin(), weights.end(), 1.0F);
  const Choice choice = Solver(rows, weights).within(budget);
  const auto result = std::make_shared<const KeptRows>(kept(rows, weights, choice.quantizer));
  CompressedTransfer transfer;
  transfer.name = selection == Selection::kAreaWeighted ? "haar" : "haar_magnitude";
  transfer.parameters =
      std::to_string(result->indices.size()) + " coefficients of " + std::to_string(choice.bits) + " bits";
  transfer.bytes = result->bytes();
  transfer.operations = 2 * result->indices.size();
  transfer.value_count = rows.rowCount();
  transfer.multiply = [result](std::span<const Radiance4> light, std::span<Radiance4> values) {
    multiply(*result, light, values);
  };
  return transfer;
}

}  // namespace bakelight::compression
