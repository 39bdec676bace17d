#include "transport/glossy_evaluator.h"

#include <hwy/cache_control.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "transport/glossy_tiles.h"

namespace bakelight::transport {
namespace {

// Kept between calls: to allocate takes longer than to evaluate a tile.
class Scratch {
 public:
  float* reserve(std::size_t size) {
    if (size > capacity_) {
      values_ = AlignedFloats(size);
      capacity_ = size;
    }
    return values_.data();
  }

 private:
  AlignedFloats values_;
  std::size_t capacity_ = 0;
};

// Asks ahead of time for the rows of a tile of neighbours, of which the first lines came with the tile
// before: rows of coefficients lie far apart, which hardware does not foresee.
void prefetchRows(TileRows rows, std::size_t row_count) {
  for (std::size_t i = 0; i < row_count; ++i) hwy::Prefetch(rows.rows + i * rows.stride + kTile - 1);
}

// Rows in the order of the tiles, vertex by vertex. Two passes of small transpositions, here and when a tile
// is evaluated, touch each cache line once; to gather from all coefficients' rows would touch most of them 16
// times.
class SortedRows {
 public:
  SortedRows(const GlossyTiles& tiles, std::span<const float> rows)
      : pitch_((tiles.shape().rows + kTile - 1) / kTile * kTile) {
    thread_local Scratch scratch;
    values_ = scratch.reserve(tiles.tileCount() * kTile * pitch_);
    const std::size_t count = tiles.vertexCount(), row_count = tiles.shape().rows;
    constexpr std::size_t kBlocksPerTask = 16;
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, (count + kTile - 1) / kTile, kBlocksPerTask),
        [&](const auto& blocks) {
          for (std::size_t block = blocks.begin(); block < blocks.end(); ++block) {
            const std::size_t first = block * kTile;
            const std::uint32_t* positions = &tiles.positions()[first];
            if (first + 2 * kTile < count) prefetchRows({&rows[first + kTile], count}, row_count);
            if (first + kTile <= count) {
              kernels().scatterRows({&rows[first], count}, row_count, positions, pitch_, values_);
            } else {
              for (std::size_t v = first; v < count; ++v)
                for (std::size_t i = 0; i < row_count; ++i)
                  values_[tiles.positions()[v] * pitch_ + i] = rows[i * count + v];
            }
          }
        });
  }

  std::size_t pitch() const { return pitch_; }
  const float* ofTile(std::size_t tile) const { return values_ + tile * kTile * pitch_; }

 private:
  std::size_t pitch_;
  float* values_;
};

}  // namespace

struct GlossyEvaluator::Implementation {
  std::unique_ptr<const GlossyTiles> tiles;

  // Calls visit(tile, scratch of the tiles, own scratch of `size` floats) for each tile, in parallel.
  template <class Visit>
  void forEachTile(const LightTables& light, std::size_t size, const Visit& visit) const {
    const std::vector<TileRange>& ranges = tiles->ranges();
    tbb::parallel_for(std::size_t{0}, ranges.size(), [&](std::size_t r) {
      thread_local Scratch kept;
      float* own = kept.reserve(size + tiles->scratchSize());
      float* scratch = own + size;
      tiles->beginRange(ranges[r], light, scratch);
      for (std::size_t tile = ranges[r].begin; tile < ranges[r].end; ++tile) visit(tile, scratch, own);
    });
  }
};

GlossyEvaluator::GlossyEvaluator(const formats::RadianceTransfer& transfer)
    : implementation_(std::make_unique<Implementation>(Implementation{makeGlossyTiles(transfer)})) {}

GlossyEvaluator::~GlossyEvaluator() = default;

std::vector<Float3> GlossyEvaluator::transferredRadiance(std::span<const Float3> light) const {
  const GlossyTiles& tiles = *implementation_->tiles;
  const std::size_t rows = tiles.shape().rows;
  const LightTables tables = tiles.prepare(light);
  std::vector<Float3> transferred(tiles.vertexCount() * rows);
  implementation_->forEachTile(
      tables, rows * 3 * kTile, [&](std::size_t tile, float* scratch, float* result) {
        std::fill_n(result, rows * 3 * kTile, 0.0f);
        tiles.transfer(tile, tables, scratch, result);
        const std::span<const std::uint32_t> vertices = tiles.vertices(tile);
        for (std::size_t lane = 0; lane < vertices.size(); ++lane)
          for (std::size_t i = 0; i < rows; ++i)
            for (std::size_t c = 0; c < 3; ++c)
              transferred[vertices[lane] * rows + i][c] = result[(i * 3 + c) * kTile + lane];
      });
  return transferred;
}

void GlossyEvaluator::shade(std::span<const Float3> light, std::span<const float> rows,
                            std::span<Float3> radiance) const {
  const GlossyTiles& tiles = *implementation_->tiles;
  const std::size_t row_count = tiles.shape().rows, count = tiles.vertexCount();
  if (rows.size() != row_count * count || radiance.size() != count)
    throw std::invalid_argument("GlossyEvaluator: rows or radiance do not fit the vertices");
  const LightTables tables = tiles.prepare(light);
  // Tiles of neighbours read the rows where they are, but for the last one if it is not full.
  const bool in_place = tiles.isContiguous();
  std::optional<SortedRows> sorted;
  if (!in_place) sorted.emplace(tiles, rows);
  const std::size_t gathered_size = (row_count + kTile) * kTile;
  implementation_->forEachTile(
      tables, gathered_size + 3 * kTile, [&](std::size_t tile, float* scratch, float* own) {
        float *gathered = own, *result = own + gathered_size;
        const std::span<const std::uint32_t> vertices = tiles.vertices(tile);
        TileRows tile_rows{gathered, kTile};
        if (!in_place) {
          kernels().gatherRows(sorted->ofTile(tile), sorted->pitch(), row_count, gathered);
        } else if (vertices.size() == kTile) {
          tile_rows = {&rows[vertices[0]], count};
          if (vertices.back() + kTile < count) prefetchRows({&rows[vertices[0] + kTile], count}, row_count);
        } else {
          for (std::size_t i = 0; i < row_count; ++i)
            std::copy_n(&rows[i * count + vertices[0]], vertices.size(), gathered + i * kTile);
        }
        tiles.shade(tile, tables, tile_rows, scratch, result);
        for (std::size_t lane = 0; lane < vertices.size(); ++lane)
          radiance[vertices[lane]] = {result[lane], result[kTile + lane], result[2 * kTile + lane]};
      });
}

std::size_t GlossyEvaluator::tableBytes() const {
  return implementation_->tiles->tableBytes();
}

double GlossyEvaluator::multiplyAdds() const {
  return implementation_->tiles->multiplyAdds();
}

}  // namespace bakelight::transport
