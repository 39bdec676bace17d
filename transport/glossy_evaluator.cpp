#include "transport/glossy_evaluator.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
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

GlossyEvaluator::GlossyEvaluator(const formats::ShTransfer& transfer)
    : implementation_(std::make_unique<Implementation>(Implementation{makeGlossyTiles(transfer)})) {}

GlossyEvaluator::~GlossyEvaluator() = default;

std::vector<Float3> GlossyEvaluator::transferredRadiance(std::span<const Float3> light) const {
  const GlossyTiles& tiles = *implementation_->tiles;
  std::vector<Float3> transferred(tiles.vertexCount() * tiles.shape().rows);
  transferredRadiance(light, transferred);
  return transferred;
}

void GlossyEvaluator::transferredRadiance(std::span<const Float3> light,
                                          std::span<Float3> transferred) const {
  const GlossyTiles& tiles = *implementation_->tiles;
  const std::size_t rows = tiles.shape().rows;
  if (transferred.size() != tiles.vertexCount() * rows)
    throw std::invalid_argument("GlossyEvaluator: transferred radiance does not fit the vertices");
  const LightTables tables = tiles.prepare(light);
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
}

std::size_t GlossyEvaluator::tableBytes() const {
  return implementation_->tiles->tableBytes();
}

double GlossyEvaluator::multiplyAdds() const {
  return implementation_->tiles->multiplyAdds();
}

}  // namespace bakelight::transport
