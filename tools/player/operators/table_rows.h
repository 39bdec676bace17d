// A table of which each row becomes output_order² × RGB values: what the operators have in common.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/gpu_table.h"

namespace bakelight::player {

class TableRows {
 public:
  // Uploads the table, and makes room for the values. `largest_block_bytes`: see rowRanges.
  TableRows(const formats::EncodedTable& table, int output_order, std::size_t largest_block_bytes);

  const GpuTable& table() const { return table_; }
  std::size_t coefficients() const { return coefficients_; }  // output_order²
  const Buffer& values() const { return values_; }            // rows × coefficients × RGB float32

  // table.glsl's definitions, and ROW_COEFFICIENTS.
  std::string definitions() const;
  // Runs a program of `items_per_row` work items a row over all rows: table at bindings 0 and 1, values at 2,
  // and `clusters`, one uint32 a row, at 4; uniform 0 tells the rows of the range.
  void run(const Program& program, std::size_t items_per_row, const Buffer* clusters = nullptr) const;

  std::size_t gpuBytes() const { return table_.gpuBytes() + sizeInBytes(values_); }
  std::size_t dispatchCount() const { return ranges_.size(); }

 private:
  std::size_t valueBytes() const { return coefficients_ * sizeof(formats::Float3); }  // of a row

  std::size_t coefficients_;
  GpuTable table_;
  std::vector<RowRange> ranges_;
  Buffer values_;
};

// "#define NAME 5u"
std::string define(const std::string& name, std::size_t value);
// Throws std::invalid_argument otherwise.
void requireFit(bool tables_fit);

}  // namespace bakelight::player
