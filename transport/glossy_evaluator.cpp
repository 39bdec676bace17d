#include "transport/glossy_evaluator.h"

#include <hwy/cache_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>

#include "transport/glossy_tiles.h"

namespace bakelight::transport {
namespace {

// Rows of coefficients lie far apart, which hardware does not foresee: asks for those of a tile ahead.
void prefetchRows(std::span<const float> rows, std::size_t row_count, std::size_t vertex) {
  const std::size_t stride = rows.size() / row_count;
  for (std::size_t i = 0; i < row_count; ++i) hwy::Prefetch(rows.data() + i * stride + vertex);
}

// Kept between calls: to allocate takes longer than to evaluate a tile. `size` is a multiple of kTile.
float* threadScratch(std::size_t size) {
  thread_local AlignedFloats scratch;
  thread_local std::size_t capacity = 0;
  if (size > capacity) {
    scratch = AlignedFloats(size);
    capacity = size;
  }
  return scratch.data();
}

}  // namespace

struct GlossyEvaluator::Implementation {
  std::unique_ptr<const GlossyTiles> tiles;

  // Calls visit(tile, scratch of the tiles, own scratch of `size` floats) for each tile, in parallel.
  template <class Visit>
  void forEachTile(const LightTables& light, std::size_t size, const Visit& visit) const {
    const std::vector<TileRange>& ranges = tiles->ranges();
    tbb::parallel_for(std::size_t{0}, ranges.size(), [&](std::size_t r) {
      float* own = threadScratch(size + tiles->scratchSize());
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
  const std::size_t gathered_size = row_count * kGatherPitch;
  implementation_->forEachTile(
      tables, gathered_size + 3 * kTile, [&](std::size_t tile, float* scratch, float* own) {
        float *gathered = own, *result = own + gathered_size;
        const std::span<const std::uint32_t> vertices = tiles.vertices(tile);
        TileRows tile_rows{gathered, kGatherPitch};
        if (tiles.isContiguous() && vertices.size() == kTile) {
          tile_rows = {&rows[vertices[0]], count};
          prefetchRows(rows, row_count, std::min<std::size_t>(vertices[0] + 2 * kTile - 1, count - 1));
        } else {
          tiles.gatherRows(tile, rows, gathered);
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
