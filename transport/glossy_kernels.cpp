#include "transport/glossy_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "transport/glossy_kernels.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace bakelight::transport::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using formats::Precision;

using Floats = hn::CappedTag<float, kTile>;
using Vector = hn::Vec<Floats>;
constexpr Floats kFloats;
constexpr std::size_t kLanes = hn::MaxLanes(Floats());
constexpr std::size_t kPrefetchAhead = 8192;  // bytes; the best of 1, 2, 4 and 8 KiB on a Zen 4

// Values as numbers; for codes, without their scale.
HWY_INLINE Vector load(const float* values) {
  return hn::Load(kFloats, values);
}
HWY_INLINE Vector load(const hwy::float16_t* values) {
  return hn::PromoteTo(kFloats, hn::Load(hn::Rebind<hwy::float16_t, Floats>(), values));
}
HWY_INLINE Vector load(const std::uint8_t* values) {
  const hn::RebindToSigned<Floats> integers;
  return hn::ConvertTo(kFloats,
                       hn::PromoteTo(integers, hn::Load(hn::Rebind<std::uint8_t, Floats>(), values)));
}

// Calls visit(pointer to the values in their type).
template <class Visit>
HWY_INLINE void withType(const TileValues& values, const Visit& visit) {
  switch (values.precision) {
    case Precision::kFloat32:
      return visit(reinterpret_cast<const float*>(values.data));
    case Precision::kFloat16:
      return visit(reinterpret_cast<const hwy::float16_t*>(values.data));
    case Precision::kUint8:
      return visit(reinterpret_cast<const std::uint8_t*>(values.data));
  }
}

// Calls visit<size>() for a block's size.
template <std::size_t kMaximum, class Visit>
HWY_INLINE void withSize(std::size_t size, const Visit& visit) {
  if constexpr (kMaximum > 1) {
    if (size < kMaximum) return withSize<kMaximum - 1>(size, visit);
  }
  visit.template operator()<kMaximum>();
}

void decode(const TileValues& values, const float* offset, std::size_t count, float* lanes) {
  withType(values, [&]<class T>(const T* data) {
    for (std::size_t e = 0; e < count; ++e)
      for (std::size_t lane = 0; lane < kTile; lane += kLanes) {
        Vector value = load(data + e * kTile + lane);
        if constexpr (sizeof(T) == 1)
          value = hn::MulAdd(value, hn::Set(kFloats, values.scale[e]), hn::Set(kFloats, offset[e]));
        hn::Store(value, kFloats, lanes + e * kTile + lane);
      }
  });
}

// kRows rows from `begin` on. cell(e, lane) is entry e of the row-major matrix.
template <std::size_t kRows, std::size_t kColors, class Cell>
HWY_INLINE void multiplyRows(const Cell& cell, std::size_t begin, std::size_t columns, const float* light,
                             float* transferred) {
  for (std::size_t lane = 0; lane < kTile; lane += kLanes) {
    Vector sums[kRows * kColors];
#pragma GCC unroll 12
    for (std::size_t s = 0; s < kRows * kColors; ++s)
      sums[s] = hn::Load(kFloats, transferred + ((begin + s / kColors) * 3 + s % kColors) * kTile + lane);
    for (std::size_t j = 0; j < columns; ++j) {
#pragma GCC unroll 4
      for (std::size_t row = 0; row < kRows; ++row) {
        const Vector value = cell((begin + row) * columns + j, lane);
#pragma GCC unroll 3
        for (std::size_t c = 0; c < kColors; ++c)
          sums[row * kColors + c] =
              hn::MulAdd(value, hn::Set(kFloats, light[j * 3 + c]), sums[row * kColors + c]);
      }
    }
#pragma GCC unroll 12
    for (std::size_t s = 0; s < kRows * kColors; ++s)
      hn::Store(sums[s], kFloats, transferred + ((begin + s / kColors) * 3 + s % kColors) * kTile + lane);
  }
}

template <std::size_t kColors, class Cell>
HWY_INLINE void multiplyAll(const Cell& cell, MatrixShape shape, const float* light, float* transferred) {
  const Blocks blocks{shape.rows, kRowBlock};
  for (std::size_t block = 0; block < blocks.blocks(); ++block) {
    const std::size_t begin = blocks.begin(block), size = blocks.begin(block + 1) - begin;
    withSize<kRowBlock>(size, [&]<std::size_t kRows>() {
      multiplyRows<kRows, kColors>(cell, begin, shape.columns, light, transferred);
    });
  }
}

void multiplyMatrices(const TileValues& matrices, const float* offset, MatrixShape shape, const float* light,
                      int first_color, int last_color, float* transferred) {
  withType(matrices, [&]<class T>(const T* data) {
    const auto cell = [&](std::size_t e, std::size_t lane) HWY_ATTR {
      const T* values = data + e * kTile + lane;
      if (lane == 0) hwy::Prefetch(reinterpret_cast<const std::byte*>(values) + kPrefetchAhead);
      if constexpr (sizeof(T) == 1)
        return hn::MulAdd(load(values), hn::Set(kFloats, matrices.scale[e]), hn::Set(kFloats, offset[e]));
      else
        return load(values);
    };
    if (last_color - first_color == 3) return multiplyAll<3>(cell, shape, light, transferred);
    for (int color = first_color; color < last_color; ++color)
      multiplyAll<1>(cell, shape, light + color, transferred + static_cast<std::size_t>(color) * kTile);
  });
}

void multiplySlots(const float* lanes, const std::uint16_t* slots, MatrixShape shape, const float* light,
                   float* transferred) {
  const auto cell = [&](std::size_t e, std::size_t lane)
                        HWY_ATTR { return hn::Load(kFloats, lanes + slots[e] * kTile + lane); };
  multiplyAll<3>(cell, shape, light, transferred);
}

struct SumCursor {
  const std::uint16_t* source;
  const float* factor;
  float* result;
};

// kBatches batches side by side, each of kSums sums over one source list, so that a vector that was loaded
// serves all of a batch and enough sums are under way to hide the latency of a multiply-add.
template <std::size_t kBatches, std::size_t kSums>
HWY_INLINE void sumSideBySide(SumCursor cursor, std::size_t length, const float* lanes) {
  for (std::size_t lane = 0; lane < kTile; lane += kLanes) {
    Vector sums[kBatches * kSums];
#pragma GCC unroll 8
    for (std::size_t s = 0; s < kBatches * kSums; ++s) sums[s] = hn::Zero(kFloats);
    for (std::size_t e = 0; e < length; ++e) {
#pragma GCC unroll 8
      for (std::size_t batch = 0; batch < kBatches; ++batch) {
        const Vector value = hn::Load(kFloats, lanes + cursor.source[batch * length + e] + lane);
#pragma GCC unroll 4
        for (std::size_t s = 0; s < kSums; ++s)
          sums[batch * kSums + s] =
              hn::MulAdd(value, hn::Set(kFloats, cursor.factor[(batch * length + e) * kSums + s]),
                         sums[batch * kSums + s]);
      }
    }
#pragma GCC unroll 8
    for (std::size_t s = 0; s < kBatches * kSums; ++s)
      hn::Store(sums[s], kFloats, cursor.result + s * kTile + lane);
  }
}

template <std::size_t kSums>
HWY_INLINE SumCursor sumBatches(const SumGroup& group, SumCursor cursor, const float* lanes) {
  constexpr std::size_t kSideBySide = kSums > 2 ? 1 : 4 / kSums;  // more would spill registers
  const std::size_t length = group.length;
  const auto advance = [&](std::size_t batches) {
    cursor.source += batches * length;
    cursor.factor += batches * length * kSums;
    cursor.result += batches * kSums * kTile;
  };
  std::size_t batch = 0;
  for (; batch + kSideBySide <= group.batches; batch += kSideBySide) {
    sumSideBySide<kSideBySide, kSums>(cursor, length, lanes);
    advance(kSideBySide);
  }
  for (; batch < group.batches; ++batch) {
    sumSideBySide<1, kSums>(cursor, length, lanes);
    advance(1);
  }
  return cursor;
}

void sparseSums(const SumGroup* groups, std::size_t group_count, const std::uint16_t* source,
                const float* factor, const float* lanes, float* result) {
  SumCursor cursor{source, factor, result};
  for (std::size_t group = 0; group < group_count; ++group)
    withSize<kSumBatch>(groups[group].batch, [&]<std::size_t kSums>() {
      cursor = sumBatches<kSums>(groups[group], cursor, lanes);
    });
}

// Adds members first … of one block to their products, one vector of row lanes.
template <std::size_t kMembers, std::size_t kColors, class T>
HWY_INLINE void multiplyMembers(const T* basis, std::size_t columns, const float* light_lanes,
                                std::size_t row_lanes, float* product) {
  for (std::size_t lane = 0; lane < kTile; lane += kLanes) {
    Vector sums[kMembers * kColors];
#pragma GCC unroll 12
    for (std::size_t s = 0; s < kMembers * kColors; ++s)
      sums[s] = hn::Load(kFloats, product + (s / kColors * 3 + s % kColors) * row_lanes + lane);
    for (std::size_t j = 0; j < columns; ++j) {
      Vector values[kMembers];
#pragma GCC unroll 4
      for (std::size_t member = 0; member < kMembers; ++member)
        values[member] = load(basis + (j * kMembers + member) * kTile + lane);
#pragma GCC unroll 3
      for (std::size_t color = 0; color < kColors; ++color) {
        const Vector light = hn::Load(kFloats, light_lanes + (j * 3 + color) * row_lanes + lane);
#pragma GCC unroll 4
        for (std::size_t member = 0; member < kMembers; ++member)
          sums[member * kColors + color] = hn::MulAdd(values[member], light, sums[member * kColors + color]);
      }
    }
#pragma GCC unroll 12
    for (std::size_t s = 0; s < kMembers * kColors; ++s)
      hn::Store(sums[s], kFloats, product + (s / kColors * 3 + s % kColors) * row_lanes + lane);
  }
}

void multiplyBasis(const TileValues& basis, std::size_t members, MatrixShape shape, const float* light_lanes,
                   int first_color, int last_color, float* product) {
  const Blocks blocks{members, kRowBlock};
  const std::size_t row_vectors = (shape.rows + kTile - 1) / kTile, row_lanes = row_vectors * kTile;
  withType(basis, [&]<class T>(const T* data) {
    for (std::size_t block = 0; block < blocks.blocks(); ++block) {
      const std::size_t begin = blocks.begin(block), size = blocks.begin(block + 1) - begin;
      for (std::size_t vector = 0; vector < row_vectors; ++vector) {
        withSize<kRowBlock>(size, [&]<std::size_t kMembers>() {
          const T* values = data + (begin * row_vectors + vector * kMembers) * shape.columns * kTile;
          const float* light = light_lanes + first_color * row_lanes + vector * kTile;
          float* target = product + (begin * 3 + first_color) * row_lanes + vector * kTile;
          if (last_color - first_color == 3)
            multiplyMembers<kMembers, 3>(values, shape.columns, light, row_lanes, target);
          else
            multiplyMembers<kMembers, 1>(values, shape.columns, light, row_lanes, target);
        });
      }
    }
  });
}

// visit(i, sums) for blocks of rows: sums[row · 3 + c] is transferred(i + row, c).
template <std::size_t kRows, class Visit>
HWY_INLINE void combineRows(const float* product, std::size_t components, const float* weights,
                            std::size_t begin, std::size_t row_lanes, std::size_t lane, const Visit& visit) {
  Vector sums[kRows * 3];
  const float* member = product + begin;
#pragma GCC unroll 12
  for (std::size_t s = 0; s < kRows * 3; ++s) sums[s] = hn::Set(kFloats, member[s % 3 * row_lanes + s / 3]);
  for (std::size_t k = 0; k < components; ++k) {
    member += 3 * row_lanes;
    const Vector weight = hn::Load(kFloats, weights + k * kTile + lane);
#pragma GCC unroll 12
    for (std::size_t s = 0; s < kRows * 3; ++s)
      sums[s] = hn::MulAdd(weight, hn::Set(kFloats, member[s % 3 * row_lanes + s / 3]), sums[s]);
  }
  visit(sums);
}

void transferCluster(const float* product, std::size_t components, const float* weights,
                     std::size_t row_count, float* transferred) {
  const std::size_t row_lanes = (row_count + kTile - 1) / kTile * kTile;
  for (std::size_t lane = 0; lane < kTile; lane += kLanes)
    for (std::size_t i = 0; i < row_count; ++i)
      combineRows<1>(product, components, weights, i, row_lanes, lane, [&](const Vector(&sums)[3]) {
        for (std::size_t color = 0; color < 3; ++color)
          hn::Store(sums[color], kFloats, transferred + (i * 3 + color) * kTile + lane);
      });
}

const Kernels& kernelsOfTarget() {
  static constexpr Kernels table = {decode,     multiplyMatrices, multiplySlots,
                                    sparseSums, multiplyBasis,    transferCluster};
  return table;
}

}  // namespace bakelight::transport::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace bakelight::transport {

HWY_EXPORT(kernelsOfTarget);

const Kernels& kernels() {
  return HWY_DYNAMIC_DISPATCH(kernelsOfTarget)();
}

}  // namespace bakelight::transport
#endif
