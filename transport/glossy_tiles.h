// The three storages of transfer matrices, laid out in tiles of 16 vertices for the kernels. Private to
// transport/glossy_evaluator.cpp.
#pragma once

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "transport/glossy_kernels.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// Zeros, aligned for vector loads.
template <class T>
class Aligned {
 public:
  Aligned() = default;
  explicit Aligned(std::size_t size) : values_(hwy::AllocateAligned<T>(std::max<std::size_t>(size, 1))) {
    std::fill_n(values_.get(), size, T());
  }
  T* data() const { return values_.get(); }
  T& operator[](std::size_t i) const { return values_[i]; }

 private:
  hwy::AlignedFreeUniquePtr<T[]> values_;
};
using AlignedFloats = Aligned<float>;

// A table of one row a vertex, interleaved: entry e of a tile's vertices at [tile][e][lane].
struct TileTable {
  formats::Precision precision = formats::Precision::kFloat32;
  std::size_t entries = 0;  // of a vertex
  Aligned<std::byte> values;
  AlignedFloats scale, offset;  // an entry; kUint8 only

  // Of a tile, from entry `first` on.
  TileValues at(std::size_t tile, std::size_t first = 0) const {
    const std::size_t position = tile * entries + first;
    return {precision, values.data() + position * kTile * formats::bytesPerValue(precision),
            scale.data() == nullptr ? nullptr : scale.data() + first};
  }
};

// What depends on the light alone.
struct LightTables {
  AlignedFloats light;  // [j][3]
  // Clusters only:
  AlignedFloats offsets;  // [3][row lane]: what kUint8's offsets transfer; empty for other precisions
  AlignedFloats lanes;    // [j][3][row lane], see Kernels::multiplyBasis
};

// Tiles that are worked on together, all of one cluster in kCpca.
struct TileRange {
  std::size_t begin, end;
  std::uint32_t cluster;
};

class GlossyTiles {
 public:
  virtual ~GlossyTiles() = default;

  std::size_t vertexCount() const { return vertex_count_; }
  std::size_t tileCount() const { return counts_.size(); }
  MatrixShape shape() const { return shape_; }
  const std::vector<TileRange>& ranges() const { return ranges_; }
  // At most 16; fewer at the end of the mesh or of a cluster.
  std::span<const std::uint32_t> vertices(std::size_t tile) const {
    return {&vertices_[tile * kTile], counts_[tile]};
  }

  virtual LightTables prepare(std::span<const Float3> light) const = 0;
  // Floats of scratch that the calls below share within a range.
  virtual std::size_t scratchSize() const = 0;
  virtual void beginRange(const TileRange&, const LightTables&, float*) const {}
  // Adds to transferred[i · 3 + c][lane].
  virtual void transfer(std::size_t tile, const LightTables& light, float* scratch,
                        float* transferred) const = 0;

  // As GlossyEvaluator.
  virtual std::size_t tableBytes() const = 0;
  virtual double multiplyAdds() const = 0;

 protected:
  // Vertices in the mesh's order, `tiles_per_range` tiles together.
  void tileInOrder(std::size_t vertex_count, std::size_t tiles_per_range);
  // Vertices sorted by cluster.
  void tileByCluster(std::span<const std::uint32_t> clusters, std::size_t cluster_count,
                     std::size_t tiles_per_range);
  // Entry e is column columns[e] of the table; padding lanes are zero.
  TileTable interleave(const formats::EncodedTable& table, std::span<const std::uint32_t> columns) const;
  AlignedFloats copyLight(std::span<const Float3> light) const;

  std::size_t vertex_count_ = 0;
  MatrixShape shape_{0, 0};
  int channels_ = 1;

 private:
  std::vector<std::uint32_t> vertices_;  // [tile][lane]
  std::vector<std::uint8_t> counts_;     // of a tile
  std::vector<TileRange> ranges_;
};

// Throws std::invalid_argument if there are no matrices or sizes do not fit together.
std::unique_ptr<const GlossyTiles> makeGlossyTiles(const formats::ShTransfer& transfer);

}  // namespace bakelight::transport
