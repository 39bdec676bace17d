#include "tools/mesomesh/synthesis/symmetry.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

#include "transport/random.h"

namespace bakelight::mesomesh {
namespace {

constexpr std::size_t kSampledTexels = 1024;
// The first components hold what the eye would compare.
constexpr Eigen::Index kComparedChannels = 8;

using Texel = std::array<int, 2>;

Texel rotated(Texel texel, bool quarter) {
  return quarter ? Texel{-texel[1], texel[0]} : Texel{-texel[0], -texel[1]};
}

int wrapped(int value, int period) {
  const int rest = value % period;
  return rest < 0 ? rest + period : rest;
}

class Comparison {
 public:
  Comparison(const Exemplar& exemplar, bool quarter)
      : exemplar_(exemplar),
        quarter_(quarter),
        channels_(exemplar.channels.leftCols(std::min(kComparedChannels, exemplar.channels.cols()))) {}

  // Mean squared difference of `texels` to where they go.
  double difference(const std::vector<Texel>& texels, Texel shift) const {
    double sum = 0;
    for (const Texel& texel : texels) {
      const Texel turned = rotated(texel, quarter_);
      sum +=
          (channels_.row(row(texel)) - channels_.row(row({wrapped(turned[0] + shift[0], exemplar_.width),
                                                          wrapped(turned[1] + shift[1], exemplar_.height)})))
              .squaredNorm();
    }
    return sum / static_cast<double>(texels.size());
  }
  double meanSquare() const {
    return channels_.cast<double>().squaredNorm() / static_cast<double>(channels_.rows());
  }

 private:
  Eigen::Index row(Texel texel) const {
    return static_cast<Eigen::Index>(texel[1]) * exemplar_.width + texel[0];
  }

  const Exemplar& exemplar_;
  bool quarter_;
  Samples channels_;
};

std::vector<Texel> allTexels(const Exemplar& exemplar) {
  std::vector<Texel> texels;
  for (int y = 0; y < exemplar.height; ++y)
    for (int x = 0; x < exemplar.width; ++x) texels.push_back({x, y});
  return texels;
}

std::vector<Texel> sampledTexels(const Exemplar& exemplar) {
  if (exemplar.texelCount() <= kSampledTexels) return allTexels(exemplar);
  std::vector<Texel> texels;
  for (std::size_t i = 0; i < kSampledTexels; ++i) {
    const auto texel = static_cast<int>(transport::scrambled(i) % exemplar.texelCount());
    texels.push_back({texel % exemplar.width, texel / exemplar.width});
  }
  return texels;
}

ExemplarSymmetry::Turn bestTurn(const Exemplar& exemplar, bool quarter) {
  if (quarter && exemplar.width != exemplar.height) return {};
  const Comparison comparison(exemplar, quarter);
  const double mean_square = comparison.meanSquare();
  const Texel middle = {exemplar.width - 1, quarter ? 0 : exemplar.height - 1};
  if (mean_square == 0) return {1, middle};
  Texel best = middle;
  if (exemplar.periodic) {
    const std::vector<Texel> sampled = sampledTexels(exemplar), shifts = allTexels(exemplar);
    std::vector<double> differences(shifts.size());
    tbb::parallel_for(std::size_t{0}, shifts.size(),
                      [&](std::size_t s) { differences[s] = comparison.difference(sampled, shifts[s]); });
    best = shifts[static_cast<std::size_t>(std::min_element(differences.begin(), differences.end()) -
                                           differences.begin())];
  }
  // Two texels that have nothing to do with each other differ by twice the variance.
  const double likeness = 1 - comparison.difference(allTexels(exemplar), best) / (2 * mean_square);
  return {std::max(0.0, likeness), best};
}

}  // namespace

ExemplarSymmetry measureSymmetry(const Exemplar& exemplar) {
  return {bestTurn(exemplar, true), bestTurn(exemplar, false)};
}

}  // namespace bakelight::mesomesh
