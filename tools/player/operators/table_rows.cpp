#include "tools/player/operators/table_rows.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "transport/sh.h"

namespace bakelight::player {

TableRows::TableRows(const formats::EncodedTable& table, int output_order, std::size_t largest_block_bytes)
    : coefficients_(transport::coefficientCount(output_order)),
      table_(table),
      ranges_(rowRanges(table_.rows(), std::max(table_.rowBytes(), valueBytes()), coefficients_,
                        largest_block_bytes)),
      values_(makeBuffer(table_.rows() * valueBytes(), nullptr)) {}

std::string TableRows::definitions() const {
  return table_.definitions() + define("ROW_COEFFICIENTS", coefficients_);
}

void TableRows::run(const Program& program, std::size_t items_per_row, const Buffer* clusters) const {
  glUseProgram(program.name());
  for (const RowRange& range : ranges_) {
    table_.bind(range);
    bindRows(2, values_, range, valueBytes());
    if (clusters != nullptr) bindRows(4, *clusters, range, sizeof(std::uint32_t));
    glUniform1ui(0, static_cast<GLuint>(range.count));
    dispatchItems(range.count * items_per_row);
  }
}

std::string define(const std::string& name, std::size_t value) {
  return "#define " + name + " " + std::to_string(value) + "u\n";
}

void requireFit(bool tables_fit) {
  if (!tables_fit) throw std::invalid_argument("the tables of glossy transfer do not fit together");
}

}  // namespace bakelight::player
