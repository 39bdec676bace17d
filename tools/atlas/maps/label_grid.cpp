#include "tools/atlas/maps/label_grid.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace bakelight::atlas {

template <class Visit>
void LabelGrid::forEachNeighbor(Texel texel, Visit visit) {
  const int last = resolution_ - 1;
  for (std::int32_t j = std::max(texel.j - 1, 0); j <= std::min(texel.j + 1, last); ++j)
    for (std::int32_t i = std::max(texel.i - 1, 0); i <= std::min(texel.i + 1, last); ++i)
      if (i != texel.i || j != texel.j) visit(Texel{i, j}, static_cast<std::size_t>(j) * resolution_ + i);
}

void LabelGrid::findFront() {
  if (!reached_.empty()) return;
  reached_.assign(labels_.size(), 0);
  for (std::int32_t j = 0; j < resolution_; ++j)
    for (std::int32_t i = 0; i < resolution_; ++i)
      if (at(i, j) != kNone) front_.push_back({i, j});
}

void LabelGrid::grow() {
  findFront();
  ++steps_;
  std::vector<Texel> next;
  for (const Texel texel : front_) {
    const std::int32_t label = at(texel.i, texel.j);
    forEachNeighbor(texel, [&](Texel neighbor, std::size_t index) {
      if (labels_[index] == kNone) {
        labels_[index] = label;
        reached_[index] = static_cast<std::uint16_t>(steps_);
        next.push_back(neighbor);
      } else if (reached_[index] == steps_) {
        labels_[index] = std::min(labels_[index], label);
      }
    });
  }
  front_ = std::move(next);
}

std::optional<int> LabelGrid::smallestGap() {
  findFront();
  constexpr int kNoGap = std::numeric_limits<int>::max();
  int gap = kNoGap;
  // A shortest way between two labels goes over neighbours that were reached from either.
  while (gap == kNoGap && !front_.empty()) {
    const std::vector<Texel> front = front_;
    grow();
    for (const Texel texel : front)
      forEachNeighbor(texel, [&](Texel, std::size_t index) {
        if (labels_[index] != at(texel.i, texel.j)) gap = std::min(gap, steps_ - 1 + reached_[index]);
      });
  }
  return gap == kNoGap ? std::nullopt : std::optional(gap);
}

}  // namespace bakelight::atlas
