#include "tools/player/gl/gpu_table.h"

#include <algorithm>
#include <stdexcept>

#include "formats/triangle_mesh.h"

namespace bakelight::player {
namespace {

using formats::Precision;

constexpr std::size_t kRowAlignment = 256;  // bytes: the strictest that GL allows for the start of a binding

constexpr std::size_t wholeWords(std::size_t bytes) {
  return (bytes + 3) / 4 * 4;
}

}  // namespace

std::vector<RowRange> rowRanges(std::size_t rows, std::size_t bytes_per_row, std::size_t items_per_row,
                                std::size_t largest_block_bytes) {
  GLint largest_groups = 0;
  GLint64 largest_block = 0;
  glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &largest_groups);
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest_block);
  const std::size_t block =
      largest_block_bytes == 0 ? static_cast<std::size_t>(largest_block) : largest_block_bytes;
  const std::size_t largest_items = static_cast<std::size_t>(largest_groups) * kGroupSize;
  const std::size_t fitting = std::min(block / bytes_per_row, largest_items / items_per_row);
  const std::size_t step = std::max<std::size_t>(fitting / kRowAlignment, 1) * kRowAlignment;
  std::vector<RowRange> ranges;
  for (std::size_t first = 0; first < rows; first += step)
    ranges.push_back({first, std::min(step, rows - first)});
  return ranges;
}

void bindRows(GLuint binding, const Buffer& buffer, const RowRange& range, std::size_t row_bytes) {
  glBindBufferRange(GL_SHADER_STORAGE_BUFFER, binding, buffer.name(),
                    static_cast<GLintptr>(range.first * row_bytes),
                    static_cast<GLsizeiptr>(wholeWords(range.count * row_bytes)));
}

void dispatchItems(std::size_t items) {
  glDispatchCompute(static_cast<GLuint>((items + kGroupSize - 1) / kGroupSize), 1, 1);
}

GpuTable::GpuTable(const formats::EncodedTable& table)
    : precision_(table.precision), rows_(table.rows), columns_(table.columns) {
  const bool quantized = precision_ == Precision::kUint8;
  if (table.data.size() != rows_ * rowBytes() || table.scale.size() != (quantized ? columns_ : 0) ||
      table.offset.size() != table.scale.size())
    throw std::invalid_argument("an encoded table's sizes contradict each other");
  words_ = makeBuffer(wholeWords(table.data.size()), nullptr, GL_DYNAMIC_STORAGE_BIT);
  glNamedBufferSubData(words_.name(), 0, static_cast<GLsizeiptr>(table.data.size()), table.data.data());
  if (!quantized) return;
  std::vector<formats::Float2> scale_and_offset;
  for (std::size_t column = 0; column < columns_; ++column)
    scale_and_offset.push_back({table.scale[column], table.offset[column]});
  quantization_ = makeBuffer(columns_ * sizeof(formats::Float2), scale_and_offset.data());
}

std::string GpuTable::definitions() const {
  std::string text = "#define TABLE_COLUMNS " + std::to_string(columns_) + "u\n";
  if (precision_ == Precision::kFloat16) text += "#define TABLE_FLOAT16\n";
  if (precision_ == Precision::kUint8) text += "#define TABLE_UINT8\n";
  return text;
}

void GpuTable::bind(const RowRange& range) const {
  bindRows(0, words_, range, rowBytes());
  if (precision_ == Precision::kUint8) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, quantization_.name());
}

}  // namespace bakelight::player
