#include "tools/mesomesh/synthesis/appearance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tools/mesomesh/synthesis/scale_space.h"
#include "transport/random.h"

namespace bakelight::mesomesh {
namespace {

constexpr int kWindow = 2 * kWindowReach + 1;
constexpr std::size_t kMostTrainingWindows = 8192;

// The window about a cell as one row: 25 places × channels.
class Windows {
 public:
  Windows(const ChannelGrid& grid, int step_cells) : grid_(grid), step_(step_cells) {}

  Eigen::Index dimensions() const { return kWindow * kWindow * grid_.values.cols(); }
  template <class Row>
  void read(int x, int y, Row&& row) const {
    const Eigen::Index channels = grid_.values.cols();
    Eigen::Index at = 0;
    for (int j = -kWindowReach; j <= kWindowReach; ++j)
      for (int i = -kWindowReach; i <= kWindowReach; ++i, at += channels)
        row.segment(at, channels) = grid_.values.row(grid_.row(x + i * step_, y + j * step_));
  }

 private:
  const ChannelGrid& grid_;
  int step_;
};

Samples trainingWindows(const Windows& windows, int width, int height, int cells_a_texel) {
  const auto texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::size_t count = std::min(texels, kMostTrainingWindows);
  Samples samples(static_cast<Eigen::Index>(count), windows.dimensions());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t texel = count == texels ? i : transport::scrambled(i) % texels;
    windows.read(static_cast<int>(texel % width) * cells_a_texel,
                 static_cast<int>(texel / width) * cells_a_texel, samples.row(static_cast<Eigen::Index>(i)));
  }
  return samples;
}

// How close coordinates may come to the border of what is not periodic. At the finest level windows stay inside,
// as far as that leaves half of a side to choose from. Coarser ones, whose windows are as wide as the exemplar,
// would have only its middle: theirs repeat the border.
double marginOf(double step, int side, bool finest) {
  return std::min(kWindowReach * step, (side - 1) / (finest ? 4.0 : 8.0));
}

}  // namespace

AppearanceLevel::AppearanceLevel(const Exemplar& exemplar, double step, int similar, bool finest)
    : width_(exemplar.width), height_(exemplar.height), periodic_(exemplar.periodic) {
  const int cells_a_texel = step < 2 ? 4 : step < 4 ? 2 : 1;
  const int step_cells = std::max(1, static_cast<int>(std::lround(step * cells_a_texel)));
  const double exact_step = static_cast<double>(step_cells) / cells_a_texel;
  step_ = static_cast<Fixed>(exact_step * kOneTexel);
  for (int bits = cells_a_texel; bits > 1; bits /= 2) --cell_bits_;
  pad_ = 2 * step_cells + 2;
  lookup_reach_ = static_cast<Fixed>(2 * step_cells + 1) * cellSize();
  if (!periodic_) {
    const auto fixed = [](double texels) { return static_cast<Fixed>(std::lround(texels * kOneTexel)); };
    const double across = marginOf(exact_step, width_, finest), up = marginOf(exact_step, height_, finest);
    least_ = {fixed(across), fixed(up)};
    greatest_ = {fixed(width_ - 1 - across), fixed(height_ - 1 - up)};
  }

  // Principal components of the windows.
  const ChannelGrid grid = upsampled(blurredFor(exemplar, exact_step), cells_a_texel);
  const Windows windows(grid, step_cells);
  const PrincipalComponents components =
      principalComponents(trainingWindows(windows, width_, height_, cells_a_texel), kAppearanceSize);
  retained_variance_ = components.retained_variance;

  // Scores of all cells, a row of them at a time.
  Samples scores = Samples::Zero(grid.values.rows(), kAppearanceSize);
  tbb::parallel_for(0, grid.height, [&](int y) {
    Samples row(grid.width, windows.dimensions());
    for (int x = 0; x < grid.width; ++x) windows.read(x, y, row.row(x));
    scores.block(static_cast<Eigen::Index>(y) * grid.width, 0, grid.width, components.axes.cols()) =
        components.scores(row);
  });

  const float largest = scores.cwiseAbs().maxCoeff();
  if (largest > 0) scores *= kAppearanceLimit / largest;
  variance_ = scores.cast<double>().squaredNorm() / static_cast<double>(scores.rows());
  stride_ = grid.width + 2 * pad_ + 1;
  const int rows = grid.height + 2 * pad_ + 1;
  table_.resize(static_cast<std::size_t>(stride_) * rows * kAppearanceSize);
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < stride_; ++x) {
      const Eigen::Index source = grid.row(x - pad_, y - pad_);
      for (int d = 0; d < kAppearanceSize; ++d)
        table_[(static_cast<std::size_t>(y) * stride_ + x) * kAppearanceSize + d] =
            static_cast<std::int16_t>(std::lround(scores(source, d)));
    }
  findSimilar(similar);
}

}  // namespace bakelight::mesomesh
