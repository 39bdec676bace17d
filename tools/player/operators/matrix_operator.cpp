#include "tools/player/operators/matrix_operator.h"

#include "tools/player/gl/gl_program.h"
#include "transport/sh.h"

namespace bakelight::player {

MatrixRows::MatrixRows(const formats::ShTransfer& transfer, const formats::EncodedTable& matrices,
                       std::size_t largest_block_bytes)
    : rows_(matrices, transfer.glossy.value().output_order, largest_block_bytes) {
  const std::size_t columns = transport::coefficientCount(transfer.order);
  requireFit(rows_.table().columns() == transfer.channels * rows_.coefficients() * columns);
  program_ = makeComputeProgram({kTableGlsl, kMatrixComp}, rows_.definitions() + "#define CHANNELS " +
                                                               std::to_string(transfer.channels) + "\n" +
                                                               define("COEFFICIENTS", columns));
}

void MatrixRows::run() const {
  rows_.run(program_, rows_.coefficients());
}

MatrixOperator::MatrixOperator(const formats::ShTransfer& transfer, const formats::MatrixOperator& matrices,
                               std::size_t largest_block_bytes)
    : matrices_(transfer, matrices.matrices, largest_block_bytes) {}

void MatrixOperator::evaluate(const Buffer& light) {
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, light.name());
  matrices_.run();
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
}

}  // namespace bakelight::player
