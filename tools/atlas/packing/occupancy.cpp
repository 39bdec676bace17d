#include "tools/atlas/packing/occupancy.h"

#include <algorithm>
#include <bit>

namespace bakelight::atlas {
namespace {

// into |= from, moved `shift` bits towards the lower ones.
void orShifted(const std::uint64_t* from, int shift, int words, std::uint64_t* into) {
  from += shift / 64;
  const int bits = shift % 64;
  if (bits == 0) {
    for (int w = 0; w < words; ++w) into[w] |= from[w];
    return;
  }
  for (int w = 0; w < words; ++w) into[w] |= from[w] >> bits | from[w + 1] << (64 - bits);
}

void setBits(std::uint64_t* words, int begin, int end) {
  for (int x = begin; x < end;) {
    const int low = x % 64, count = std::min(64 - low, end - x);
    words[x / 64] |= (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << low;
    x += count;
  }
}

}  // namespace

// Two words more a row, so that shifted ones can be read past the end.
Occupancy::Occupancy(int side)
    : side_(side), words_((side + 63) / 64 + 2), levels_(std::bit_width(static_cast<unsigned>(side))) {
  bits_.resize(static_cast<std::size_t>(levels_) * side_ * words_);
}

void Occupancy::take(const TexelMask& mask, int x, int y) {
  x += mask.left, y += mask.bottom;
  for (int r = std::max(0, -y); r < mask.height && y + r < side_; ++r) {
    for (std::uint32_t i = mask.row_begins[r]; i < mask.row_begins[r + 1]; ++i) {
      const int begin = std::max(0, x + mask.spans[i].begin), end = std::min(side_, x + mask.spans[i].end);
      for (int level = 0; level < levels_; ++level)
        setBits(row(level, y + r), std::max(0, begin - (1 << level) + 1), end);
    }
  }
}

std::optional<int> Occupancy::firstFree(const TexelMask& mask, int y, int margin) const {
  const int places = side_ - margin - mask.width + 1;  // x < places
  if (places <= margin) return std::nullopt;
  const int words = (places + 63) / 64;
  thread_local std::vector<std::uint64_t> blocked;
  blocked.assign(words, 0);
  for (int r = 0; r < mask.height; ++r)
    for (std::uint32_t i = mask.row_begins[r]; i < mask.row_begins[r + 1]; ++i) {
      const auto [begin, end] = mask.spans[i];
      const int level = std::bit_width(static_cast<unsigned>(end - begin)) - 1;
      const std::uint64_t* bits = row(level, y + r);
      orShifted(bits, begin, words, blocked.data());
      if (end - begin > 1 << level) orShifted(bits, end - (1 << level), words, blocked.data());
    }
  setBits(blocked.data(), 0, margin);
  for (int w = 0; w < words; ++w)
    if (~blocked[w]) {
      const int x = 64 * w + std::countr_one(blocked[w]);
      return x < places ? std::optional(x) : std::nullopt;
    }
  return std::nullopt;
}

}  // namespace bakelight::atlas
