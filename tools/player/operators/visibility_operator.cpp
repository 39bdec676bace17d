#include "tools/player/operators/visibility_operator.h"

#include <tbb/parallel_for.h>

#include <cstdint>
#include <cstring>

#include "tools/player/gl/gl_program.h"
#include "transport/triple_product.h"

namespace bakelight::player {
namespace {

// Coefficients that one work item of visibility.comp computes.
constexpr std::size_t kBlock = 5;

struct GatherEntry {
  std::uint32_t j;
  float value;
};

// Columns t, b, n, made orthonormal to the last digit.
Eigen::Matrix3d objectFromLocal(const formats::Float3& normal, const formats::Float4& tangent) {
  using transport::Vec3;
  const Vec3 n = transport::vec3(normal).normalized(), along(tangent[0], tangent[1], tangent[2]);
  const Vec3 t = (along - along.dot(n) * n).normalized();
  Eigen::Matrix3d frame;
  frame << t, tangent[3] * n.cross(t), n;
  return frame;
}

}  // namespace

VisibilityOperator::VisibilityOperator(const formats::ShTransfer& transfer,
                                       const formats::VisibilityOperator& visibility,
                                       std::size_t largest_block_bytes)
    : rows_(visibility.visibility, transfer.glossy.value().output_order, largest_block_bytes),
      program_(
          makeComputeProgram({kTableGlsl, kVisibilityComp}, rows_.definitions() + define("BLOCK", kBlock))),
      operator_program_(makeComputeProgram({kOperatorComp})) {
  prepareGather(transfer);
}

void VisibilityOperator::prepareGather(const formats::ShTransfer& transfer) {
  const transport::TripleProduct product(transfer.glossy->output_order, transfer.order);
  const std::size_t columns = transport::coefficientCount(product.visibilityOrder());
  requireFit(transfer.channels == 1 && rows_.table().columns() == columns);
  cell_count_ = rows_.coefficients() * columns;
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
}

void VisibilityOperator::evaluate(const Buffer& light) {
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light.name());
  gatherOperator();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, operator_.name());
  rows_.run(program_, (rows_.coefficients() + kBlock - 1) / kBlock);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

void VisibilityOperator::gatherOperator() const {
  glUseProgram(operator_program_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, operator_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, entries_.name());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, cell_ends_.name());
  glUniform1ui(0, static_cast<GLuint>(cell_count_));
  dispatchItems(cell_count_);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

std::size_t VisibilityOperator::gpuBytes() const {
  return rows_.gpuBytes() + sizeInBytes(entries_) + sizeInBytes(cell_ends_) + sizeInBytes(operator_);
}

formats::ShTransfer matricesFromVisibility(const formats::Pack& pack) {
  const formats::ShTransfer& transfer = pack.sh();
  const formats::GlossyTransfer& source = transfer.glossy.value();
  const int order = source.output_order;
  const formats::EncodedTable& table = std::get<formats::VisibilityOperator>(source.transfer).visibility;
  const transport::TripleProduct product(order, transfer.order);
  const std::size_t rows = transport::coefficientCount(order);
  const std::size_t columns = transport::coefficientCount(transfer.order);
  const std::vector<float> visibility = table.decode();
  std::vector<float> matrices(pack.mesh.vertexCount() * rows * columns);
  tbb::parallel_for(std::size_t{0}, pack.mesh.vertexCount(), [&](std::size_t v) {
    std::vector<float> matrix(rows * columns);
    product.matrixOf(std::span(visibility).subspan(v * table.columns, table.columns), matrix);
    // A left-handed frame is a right-handed one mirrored in y, which turns the sign of every m < 0.
    Eigen::Matrix3d frame = objectFromLocal(pack.mesh.normals[v], source.tangents[v]);
    const bool mirrored = frame.determinant() < 0;
    if (mirrored) frame.col(1) = -frame.col(1);
    const transport::ShRotation local_from_object(order, frame.transpose());
    std::vector<double> column(rows), turned(rows);
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = 0; i < rows; ++i) column[i] = matrix[i * columns + j];
      local_from_object.apply(column, turned);
      for (int l = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m) {
          const int i = transport::coefficientIndex(l, m);
          matrices[(v * rows + i) * columns + j] =
              static_cast<float>(mirrored && m < 0 ? -turned[i] : turned[i]);
        }
    }
  });
  formats::ShTransfer result;
  result.order = transfer.order;
  result.glossy.emplace();
  result.glossy->output_order = order;
  formats::Bytes bytes(matrices.size() * sizeof(float));
  std::memcpy(bytes.data(), matrices.data(), bytes.size());
  result.glossy->transfer = formats::MatrixOperator{formats::EncodedTable{
      formats::Precision::kFloat32, pack.mesh.vertexCount(), rows * columns, std::move(bytes), {}, {}}};
  return result;
}

}  // namespace bakelight::player
