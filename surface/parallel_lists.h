// Lists made by all threads, in the same order for any number of them.
#pragma once

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace bakelight::surface {

// The items that `keep` holds for, in order. All TBB threads.
template <class Item, class Keep>
std::vector<std::uint32_t> filtered(std::size_t count, Item item, Keep keep) {
  constexpr std::size_t kChunk = 4096;
  const std::size_t chunks = (count + kChunk - 1) / kChunk;
  std::vector<std::size_t> begin(chunks + 1, 0);
  std::vector<std::uint8_t> kept(count);
  const auto forChunk = [&](std::size_t chunk, auto&& visit) {
    for (std::size_t i = chunk * kChunk; i < std::min(count, (chunk + 1) * kChunk); ++i) visit(i);
  };
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    forChunk(chunk, [&](std::size_t i) {
      kept[i] = keep(item(i));
      begin[chunk + 1] += kept[i];
    });
  });
  std::inclusive_scan(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> result(begin.back());
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    std::size_t next = begin[chunk];
    forChunk(chunk, [&](std::size_t i) {
      if (kept[i] != 0) result[next++] = item(i);
    });
  });
  return result;
}

// Of 0 … count − 1.
template <class Keep>
std::vector<std::uint32_t> filtered(std::size_t count, Keep keep) {
  return filtered(
      count, [](std::size_t i) { return static_cast<std::uint32_t>(i); }, keep);
}

template <class Keep>
std::vector<std::uint32_t> filtered(const std::vector<std::uint32_t>& list, Keep keep) {
  return filtered(
      list.size(), [&](std::size_t i) { return list[i]; }, keep);
}

}  // namespace bakelight::surface
