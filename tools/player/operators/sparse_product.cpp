#include "tools/player/operators/sparse_product.h"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <string>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"

namespace bakelight::player {
namespace {

enum Uniform : GLint { kFirstRow, kEndRow, kFirstEntry, kAdds };  // sparse_product.comp

constexpr std::size_t kEntryAlignment = 256;  // as kRowAlignment of gpu_table.cpp
constexpr std::size_t kMostLanes = 32, kEntriesPerLane = 4;

std::size_t lanesFor(std::size_t entries, std::size_t rows) {
  const std::size_t mean = entries / std::max<std::size_t>(rows, 1);
  return std::bit_floor(std::clamp<std::size_t>(mean / kEntriesPerLane, 1, kMostLanes));
}

}  // namespace

SparseProduct::SparseProduct(const formats::SparseRows& matrix, std::size_t largest_block_bytes)
    : rows_(matrix.rows()), values_(matrix.values), lanes_(lanesFor(values_.rows(), rows_)) {
  const auto ends = matrix.endsOf(), columns = matrix.columnsOf();
  if ((values_.columns() != 1 && values_.columns() != 3) || values_.rows() != columns.size() ||
      (ends.empty() ? 0 : ends.back()) != columns.size())
    throw std::invalid_argument("the entries of a sparse matrix contradict each other");
  ranges_ = rangesOf(ends, largest_block_bytes);
  ends_ = makeBuffer(ends.size_bytes(), ends.data());
  columns_ = makeBuffer(columns.size_bytes(), columns.data());
  program_ = makeComputeProgram({kTableGlsl, kSparseProductComp},
                                values_.definitions() + "#define LANES " + std::to_string(lanes_) + "u\n");
  throwIfGlFailed("uploading a sparse matrix");
}

std::vector<SparseProduct::Range> SparseProduct::rangesOf(std::span<const std::uint32_t> ends,
                                                          std::size_t largest_block_bytes) const {
  std::vector<Range> ranges;
  if (entries() == 0) return ranges;
  const std::size_t entry_bytes = std::max(values_.rowBytes(), sizeof(std::uint32_t));
  // Of an entry each: what one binding takes; of a row each: what one dispatch takes.
  const std::size_t most_entries = rowRanges(entries(), entry_bytes, 1, largest_block_bytes).front().count;
  const std::size_t most_rows = rowRanges(rows_, 1, lanes_).front().count;
  for (std::size_t row = 0; row < rows_;) {
    const std::size_t begin = row == 0 ? 0 : ends[row - 1];
    // Empty rows at the end have none of their own.
    const std::size_t first = std::min(begin, entries() - 1) / kEntryAlignment * kEntryAlignment;
    std::size_t end = row;
    while (end < rows_ && end - row < most_rows && ends[end] - first <= most_entries) ++end;
    if (end == row)
      throw Error(ExitStatus::kNotAvailable, {"", glRendererName(), ""},
                  "a row of factors with " + std::to_string(ends[row] - begin) +
                      " entries does not fit into a storage block",
                  std::to_string(most_entries) + " entries at most", "a mesh with fewer vertices");
    const std::size_t count = ends[end - 1] - first;
    ranges.push_back({{row, end - row}, {first, std::max<std::size_t>(count, 1)}});
    row = end;
  }
  return ranges;
}

void SparseProduct::multiply(const Buffer& x, const Buffer& y, bool adds) const {
  const float nothing = 0;
  if (ranges_.empty() && !adds) glClearNamedBufferData(y.name(), GL_R32F, GL_RED, GL_FLOAT, &nothing);
  glUseProgram(program_.name());
  glUniform1i(kAdds, adds ? 1 : 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, ends_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, x.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, y.name());
  for (const Range& range : ranges_) {
    values_.bind(range.entries);
    bindRows(3, columns_, range.entries, sizeof(std::uint32_t));
    glUniform1ui(kFirstRow, static_cast<GLuint>(range.rows.first));
    glUniform1ui(kEndRow, static_cast<GLuint>(range.rows.first + range.rows.count));
    glUniform1ui(kFirstEntry, static_cast<GLuint>(range.entries.first));
    dispatchItems(range.rows.count * lanes_);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

}  // namespace bakelight::player
