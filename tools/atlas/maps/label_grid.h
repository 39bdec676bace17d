// Labels on the texels of a square that spread to their neighbours, as a king walks on a chessboard.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace bakelight::atlas {

class LabelGrid {
 public:
  static constexpr std::int32_t kNone = -1;

  explicit LabelGrid(int resolution)
      : resolution_(resolution), labels_(static_cast<std::size_t>(resolution) * resolution, kNone) {}

  int resolution() const { return resolution_; }
  std::int32_t& at(int i, int j) { return labels_[static_cast<std::size_t>(j) * resolution_ + i]; }
  std::int32_t at(int i, int j) const { return labels_[static_cast<std::size_t>(j) * resolution_ + i]; }

  // Spreads labels by one step to those without; where several arrive, the smallest stays.
  void grow();

  // How many texels without a label lie between any two with different ones, at least: one less than the
  // larger of |Δi| and |Δj|. Nothing if there are no different ones. Leaves the grid grown.
  std::optional<int> smallestGap();

 private:
  struct Texel {
    std::int32_t i, j;
  };
  void findFront();
  template <class Visit>
  void forEachNeighbor(Texel texel, Visit visit);

  int resolution_;
  int steps_ = 0;                       // that labels have spread
  std::vector<std::int32_t> labels_;    // row by row
  std::vector<std::uint16_t> reached_;  // in which step; empty before the first
  std::vector<Texel> front_;            // what the last step reached
};

}  // namespace bakelight::atlas
