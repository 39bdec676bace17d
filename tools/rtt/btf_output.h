// Rendered BTFs as a `.btf` file, and those of all materials as tables.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/btf_table.h"
#include "formats/btf_writer.h"
#include "formats/json.h"
#include "tools/rtt/directional.h"
#include "tools/stage/stage.h"

namespace bakelight::rtt {

struct BtfOutput {
  std::filesystem::path path;      // empty: none is wanted
  std::filesystem::path tables;    // likewise
  std::filesystem::path measured;  // tables that btf made of measured BTFs
  BtfOptions options;
  formats::BtfWrittenLayout layout = formats::BtfWrittenLayout::kFactorized;
  formats::BtfColorModel model = formats::BtfColorModel::kYuv;
  int rank = 128;
  formats::BtfPrecision precision = formats::BtfPrecision::kHalf;

  bool isWanted() const { return !path.empty() || !tables.empty(); }
};

void declare(stage::Tool& tool, BtfOutput& output);

// Before anything is rendered: throws Error(kUsage) where it would take too much memory, warns
// where it takes much.
void requireRoom(const BtfOutput& output, const patch::PatchGeometry& geometry, const Options& options,
                 stage::Run& run);

// Of a material: a surface that is to be rendered, or a table that is there.
struct BtfSource {
  std::string material;
  std::optional<patch::PatchGeometry> geometry;
  std::optional<formats::BtfTable> table;
};
// Renders and writes what is wanted, one after the other. A `.btf` takes the one with a geometry. Returns what stats tell of them.
formats::Json makeAndWrite(const BtfOutput& output, const std::vector<BtfSource>& sources,
                           const Options& options, stage::Run& run);

}  // namespace bakelight::rtt
