// A rendered BTF as a `.btf` file.
#pragma once

#include <filesystem>

#include "formats/btf_writer.h"
#include "formats/json.h"
#include "tools/rtt/directional.h"
#include "tools/stage/stage.h"

namespace bakelight::rtt {

struct BtfOutput {
  std::filesystem::path path;  // empty: none is wanted
  BtfOptions options;
  formats::BtfWrittenLayout layout = formats::BtfWrittenLayout::kFactorized;
  formats::BtfColorModel model = formats::BtfColorModel::kYuv;
  int rank = 128;
  formats::BtfPrecision precision = formats::BtfPrecision::kHalf;
};

void declare(stage::Tool& tool, BtfOutput& output);

// Before anything is rendered: throws Error(kUsage) where it would take too much memory, warns
// where it takes much.
void requireRoom(const BtfOutput& output, const patch::PatchGeometry& geometry, const Options& options,
                 stage::Run& run);

// Renders, writes and reads again. Returns what stats tell of it.
formats::Json makeAndWrite(const BtfOutput& output, const patch::PatchGeometry& geometry,
                           const Options& options, stage::Run& run);

}  // namespace bakelight::rtt
