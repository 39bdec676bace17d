#include "tools/player/operators/transfer_operator.h"

#include <stdexcept>

#include "tools/player/gl/gl_context.h"
#include "tools/player/operators/cluster_operator.h"
#include "tools/player/operators/matrix_operator.h"
#include "tools/player/operators/visibility_operator.h"

namespace bakelight::player {

std::unique_ptr<TransferOperator> makeTransferOperator(const formats::ShTransfer& transfer,
                                                       std::size_t largest_block_bytes) {
  if (!transfer.glossy) throw std::invalid_argument("a diffuse pack has no transfer operator");
  struct Maker {
    const formats::ShTransfer& transfer;
    std::size_t largest_block_bytes;

    std::unique_ptr<TransferOperator> operator()(const formats::MatrixOperator& matrices) const {
      return std::make_unique<MatrixOperator>(transfer, matrices, largest_block_bytes);
    }
    std::unique_ptr<TransferOperator> operator()(const formats::VisibilityOperator& visibility) const {
      return std::make_unique<VisibilityOperator>(transfer, visibility, largest_block_bytes);
    }
    std::unique_ptr<TransferOperator> operator()(const formats::ClusteredOperator& clustered) const {
      return std::make_unique<ClusterOperator>(transfer, clustered, largest_block_bytes);
    }
  };
  auto made = std::visit(Maker{transfer, largest_block_bytes}, transfer.glossy->transfer);
  throwIfGlFailed("uploading the transfer operator");
  return made;
}

}  // namespace bakelight::player
