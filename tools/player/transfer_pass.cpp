#include "tools/player/transfer_pass.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "tools/player/gl_context.h"
#include "tools/player/gl_program.h"
#include "transport/triple_product.h"

namespace bakelight::player {
namespace {

// Coefficients that one work item of visibility.comp computes.
constexpr std::size_t kVisibilityBlock = 5;

const formats::GlossyTransfer& glossyOf(const formats::ShTransfer& transfer) {
  if (!transfer.glossy) throw std::invalid_argument("a diffuse pack has no transfer matrices");
  return *transfer.glossy;
}

std::size_t matrixSize(const formats::ShTransfer& transfer) {
  return static_cast<std::size_t>(transport::coefficientCount(transfer.glossy->output_order)) *
         transport::coefficientCount(transfer.order);
}

void require(bool fits) {
  if (!fits) throw std::invalid_argument("the tables of glossy transfer do not fit together");
}

std::string define(const std::string& name, std::size_t value) {
  return "#define " + name + " " + std::to_string(value) + "u\n";
}

std::string matrixDefinitions(const formats::ShTransfer& transfer, const GpuTable& table) {
  return table.definitions() + "#define CHANNELS " + std::to_string(transfer.channels) + "\n" +
         define("ROW_COEFFICIENTS", transport::coefficientCount(transfer.glossy->output_order)) +
         define("COEFFICIENTS", transport::coefficientCount(transfer.order));
}

struct GatherEntry {
  std::uint32_t j;
  float value;
};

}  // namespace

TransferPass::TransferPass(const formats::ShTransfer& transfer, std::size_t largest_block_bytes)
    : row_coefficients_(transport::coefficientCount(glossyOf(transfer).output_order)),
      table_(glossyOf(transfer).vertexTable()) {
  const std::size_t result_bytes = row_coefficients_ * sizeof(formats::Float3);
  ranges_ = rowRanges(table_.rows(), std::max(table_.rowBytes(), result_bytes), row_coefficients_,
                      largest_block_bytes);
  transferred_ = makeBuffer(table_.rows() * result_bytes, nullptr);
  if (transfer.glossy->isInObjectFrame()) {
    prepareVisibility(transfer);
  } else if (const auto* clustered = std::get_if<formats::ClusteredOperator>(&transfer.glossy->transfer)) {
    prepareClusters(transfer, *clustered, largest_block_bytes);
  } else {
    require(table_.columns() == transfer.channels * matrixSize(transfer));
    program_ = makeComputeProgram({kTableGlsl, kMatrixComp}, matrixDefinitions(transfer, table_));
  }
  throwIfGlFailed("uploading the transfer matrices");
}

void TransferPass::prepareVisibility(const formats::ShTransfer& transfer) {
  kind_ = Kind::kVisibility;
  const transport::TripleProduct product(transfer.glossy->output_order, transfer.order);
  const std::size_t columns = transport::coefficientCount(product.visibilityOrder());
  require(transfer.channels == 1 && table_.columns() == columns);
  program_ = makeComputeProgram({kTableGlsl, kVisibilityComp},
                                table_.definitions() + define("ROW_COEFFICIENTS", row_coefficients_) +
                                    define("BLOCK", kVisibilityBlock));

  cell_count_ = row_coefficients_ * columns;
  std::vector<std::vector<GatherEntry>> cells(cell_count_);
  for (const auto& entry : product.entries())
    cells[entry.i * columns + entry.k].push_back({entry.j, entry.value});
  std::vector<GatherEntry> entries;
  std::vector<std::uint32_t> ends;
  for (const auto& cell : cells) {
    entries.insert(entries.end(), cell.begin(), cell.end());
    ends.push_back(static_cast<std::uint32_t>(entries.size()));
  }
  entries_ = makeBuffer(entries.size() * sizeof(GatherEntry), entries.data());
  cell_ends_ = makeBuffer(ends.size() * sizeof(std::uint32_t), ends.data());
  operator_ = makeBuffer(cell_count_ * sizeof(formats::Float4), nullptr);
  operator_program_ = makeComputeProgram({kOperatorComp});
}

void TransferPass::prepareClusters(const formats::ShTransfer& transfer,
                                   const formats::ClusteredOperator& clustered,
                                   std::size_t largest_block_bytes) {
  kind_ = Kind::kClusters;
  basis_ = GpuTable(clustered.basis);
  const std::size_t cluster_size = 1 + table_.columns();
  require(basis_.columns() == transfer.channels * matrixSize(transfer) && basis_.rows() % cluster_size == 0 &&
          clustered.clusters.size() == table_.rows());
  for (const std::uint32_t cluster : clustered.clusters) require(cluster < basis_.rows() / cluster_size);
  basis_ranges_ =
      rowRanges(basis_.rows(), std::max(basis_.rowBytes(), row_coefficients_ * sizeof(formats::Float3)),
                row_coefficients_, largest_block_bytes);
  clusters_ = makeBuffer(clustered.clusters.size() * sizeof(std::uint32_t), clustered.clusters.data());
  projected_ = makeBuffer(basis_.rows() * row_coefficients_ * sizeof(formats::Float3), nullptr);
  basis_program_ = makeComputeProgram({kTableGlsl, kMatrixComp}, matrixDefinitions(transfer, basis_));
  program_ = makeComputeProgram({kTableGlsl, kClusterComp},
                                table_.definitions() + define("ROW_COEFFICIENTS", row_coefficients_));
}

void TransferPass::evaluate(const Buffer& light) {
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light.name());
  if (kind_ == Kind::kVisibility) {
    evaluateOperator();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, operator_.name());
  } else if (kind_ == Kind::kClusters) {
    runRows(basis_program_, basis_, basis_ranges_, projected_);
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, projected_.name());
  }
  runRows(program_, table_, ranges_, transferred_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("transferring the light");
}

void TransferPass::evaluateOperator() const {
  glUseProgram(operator_program_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, operator_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, entries_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, cell_ends_.name());
  glUniform1ui(0, static_cast<GLuint>(cell_count_));
  dispatchItems(cell_count_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

std::size_t TransferPass::itemsOfRow() const {
  if (kind_ != Kind::kVisibility) return row_coefficients_;
  return (row_coefficients_ + kVisibilityBlock - 1) / kVisibilityBlock;
}

void TransferPass::runRows(const Program& program, const GpuTable& table, const std::vector<RowRange>& ranges,
                           const Buffer& result) const {
  glUseProgram(program.name());
  for (const RowRange& range : ranges) {
    table.bind(range);
    bindRows(2, result, range, row_coefficients_ * sizeof(formats::Float3));
    if (&table == &table_ && kind_ == Kind::kClusters) bindRows(4, clusters_, range, sizeof(std::uint32_t));
    glUniform1ui(0, static_cast<GLuint>(range.count));
    dispatchItems(range.count * itemsOfRow());
  }
}

std::size_t TransferPass::gpuBytes() const {
  return table_.gpuBytes() + basis_.gpuBytes() + sizeInBytes(transferred_) + sizeInBytes(entries_) +
         sizeInBytes(cell_ends_) + sizeInBytes(operator_) + sizeInBytes(clusters_) + sizeInBytes(projected_);
}

std::size_t TransferPass::dispatchCount() const {
  return ranges_.size() + basis_ranges_.size();
}

}  // namespace bakelight::player
