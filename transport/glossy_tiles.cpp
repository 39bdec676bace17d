#include "transport/glossy_tiles.h"

#include <tbb/parallel_for.h>

#include <cstring>
#include <stdexcept>

namespace bakelight::transport {
namespace {

AlignedFloats reorder(std::span<const float> values, std::span<const std::uint32_t> columns) {
  if (values.empty()) return {};
  AlignedFloats result(columns.size());
  for (std::size_t e = 0; e < columns.size(); ++e) result[e] = values[columns[e]];
  return result;
}

}  // namespace

void GlossyTiles::tileInOrder(std::size_t vertex_count, std::size_t tiles_per_range) {
  tileByCluster(std::vector<std::uint32_t>(vertex_count, 0), 1, tiles_per_range);
}

void GlossyTiles::tileByCluster(std::span<const std::uint32_t> clusters, std::size_t cluster_count,
                                std::size_t tiles_per_range) {
  vertex_count_ = clusters.size();
  std::vector<std::vector<std::uint32_t>> members(cluster_count);
  for (std::size_t vertex = 0; vertex < clusters.size(); ++vertex) {
    if (clusters[vertex] >= cluster_count)
      throw std::invalid_argument("GlossyEvaluator: a vertex names a cluster that does not exist");
    members[clusters[vertex]].push_back(static_cast<std::uint32_t>(vertex));
  }
  for (std::size_t cluster = 0; cluster < cluster_count; ++cluster) {
    const std::size_t first_tile = counts_.size();
    for (std::size_t begin = 0; begin < members[cluster].size(); begin += kTile) {
      const std::size_t count = std::min(kTile, members[cluster].size() - begin);
      counts_.push_back(static_cast<std::uint8_t>(count));
      vertices_.resize(counts_.size() * kTile);
      std::copy_n(members[cluster].begin() + begin, count, vertices_.end() - kTile);
    }
    for (std::size_t tile = first_tile; tile < counts_.size(); tile += tiles_per_range)
      ranges_.push_back(
          {tile, std::min(tile + tiles_per_range, counts_.size()), static_cast<std::uint32_t>(cluster)});
  }
}

TileTable GlossyTiles::interleave(const formats::EncodedTable& table,
                                  std::span<const std::uint32_t> columns) const {
  const std::size_t size = formats::bytesPerValue(table.precision);
  TileTable result{table.precision, columns.size(),
                   Aligned<std::byte>(tileCount() * columns.size() * kTile * size),
                   reorder(table.scale, columns), reorder(table.offset, columns)};
  tbb::parallel_for(std::size_t{0}, tileCount(), [&](std::size_t tile) {
    for (std::size_t lane = 0; lane < counts_[tile]; ++lane) {
      const std::byte* row = &table.data[vertices_[tile * kTile + lane] * table.rowBytes()];
      std::byte* target = result.values.data() + (tile * columns.size() * kTile + lane) * size;
      for (std::size_t e = 0; e < columns.size(); ++e)
        std::memcpy(target + e * kTile * size, row + columns[e] * size, size);
    }
  });
  return result;
}

AlignedFloats GlossyTiles::copyLight(std::span<const Float3> light) const {
  if (light.size() < shape_.columns)
    throw std::invalid_argument(
        "GlossyEvaluator: the light has fewer coefficients than the matrices columns");
  AlignedFloats copy(shape_.columns * 3);
  for (std::size_t j = 0; j < shape_.columns; ++j) std::copy_n(light[j].begin(), 3, &copy[j * 3]);
  return copy;
}

}  // namespace bakelight::transport
