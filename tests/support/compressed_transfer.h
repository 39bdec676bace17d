// Transfer in a pixel basis as packs hold what bicluster writes.
#pragma once

#include <memory>

#include "compression/shared_sums.h"
#include "formats/pixel_transfer.h"

namespace bakelight::tests {

inline formats::PixelTransfer compressed(const formats::PixelTransfer& rows,
                                         const compression::SumOptions& options = {}) {
  const formats::PixelTransferRows read(rows);
  auto grammar = std::make_shared<const formats::SumGrammar>(compression::compress(read.view(), options));
  formats::PixelTransfer result = rows;
  result.row_lengths.data = result.columns.data = result.codes.data = {};
  const formats::CodedSums coded = formats::encodeSums(*grammar);
  formats::PixelSums& sums = result.sums.emplace();
  sums.block_count = static_cast<int>(rows.blockCount());
  for (int stream = 0; stream < formats::kSumStreams; ++stream)
    sums.streams[stream].data = coded.streams[stream];
  sums.grammar = std::move(grammar);
  return result;
}

}  // namespace bakelight::tests
