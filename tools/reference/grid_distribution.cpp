#include "tools/reference/grid_distribution.h"

#include "transport/random.h"

namespace bakelight::reference {

GridDistribution::GridDistribution(int width, int height, std::span<const double> weights)
    : width_(width), rows_(height + 1), columns_(static_cast<std::size_t>(height) * (width + 1)) {
  const auto w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
  std::vector<double> row_weights(h);
  for (std::size_t y = 0; y < h; ++y)
    row_weights[y] = transport::accumulateProbabilities(weights.subspan(y * w, w),
                                                        std::span(columns_).subspan(y * (w + 1), w + 1));
  total_ = transport::accumulateProbabilities(row_weights, rows_);
}

double GridDistribution::probability(int x, int y) const {
  const double* columns = &columns_[static_cast<std::size_t>(y) * (width_ + 1)];
  return (rows_[y + 1] - rows_[y]) * (columns[x + 1] - columns[x]);
}

GridDistribution::Cell GridDistribution::draw(double u, double v) const {
  const transport::DrawnInterval row = transport::drawInterval(rows_, u);
  const auto row_size = static_cast<std::size_t>(width_) + 1;
  const transport::DrawnInterval column =
      transport::drawInterval(std::span(columns_).subspan(row.index * row_size, row_size), v);
  return {static_cast<int>(column.index), static_cast<int>(row.index), column.rest, row.rest};
}

}  // namespace bakelight::reference
