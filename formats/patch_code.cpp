#include "formats/patch_code.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <Eigen/Core>
#include <numbers>
#include <stdexcept>

#include "formats/error.h"
#include "formats/factored_patch.h"
#include "formats/patch_levels.h"
#include "formats/signed_codes.h"

namespace bakelight::formats {
namespace {

using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Part = Eigen::Map<Matrix>;

constexpr int kLargestTile = 64;
// Rounded up from here on: coefficients are the more often small ones.
constexpr float kRounding = 0.6F;
constexpr float kLargestLevel = 1e9F;

// Orthonormal: row k the cosine of frequency k.
Matrix cosines(int count) {
  Matrix result(count, count);
  for (int k = 0; k < count; ++k)
    for (int i = 0; i < count; ++i)
      result(k, i) = static_cast<float>(std::sqrt((k == 0 ? 1.0 : 2.0) / count) *
                                        std::cos(std::numbers::pi * (i + 0.5) * k / count));
  return result;
}

// From which of `to` tiles on; tiles of one direction differ by a texel at most.
std::vector<int> tileBounds(int texels) {
  const int tiles = (texels + kLargestTile - 1) / kLargestTile;
  std::vector<int> bounds;
  for (int i = 0; i <= tiles; ++i) bounds.push_back(static_cast<int>(std::int64_t{texels} * i / tiles));
  return bounds;
}

// Of one tile: rows × columns × components × views × views values, or coefficients in their place.
struct Tile {
  int x = 0, y = 0, width = 0, height = 0;
  std::size_t first = 0;  // of its coefficients among those of all tiles
};

std::vector<Tile> tilesOf(const PatchValuesShape& shape) {
  const std::vector<int> across = tileBounds(shape.width), down = tileBounds(shape.height);
  std::vector<Tile> tiles;
  std::size_t first = 0;
  for (std::size_t j = 0; j + 1 < down.size(); ++j)
    for (std::size_t i = 0; i + 1 < across.size(); ++i) {
      tiles.push_back({across[i], down[j], across[i + 1] - across[i], down[j + 1] - down[j], first});
      first += static_cast<std::size_t>(tiles.back().width) * tiles.back().height * shape.views *
               shape.views * shape.components;
    }
  return tiles;
}

class TileTransform {
 public:
  TileTransform(const PatchValuesShape& shape, const Tile& tile)
      : shape_(shape),
        tile_(tile),
        views_(cosines(shape.views)),
        across_(cosines(tile.width)),
        down_(cosines(tile.height)) {}

  void forward(std::span<const float> values, float* coefficients) const {
    forTexels([&](std::size_t texel, std::size_t place) {
      const float* from = &values[texel * a_texel_];
      float* to = coefficients + place * a_texel_;
      for (std::size_t v = 0; v < view_count_; ++v)
        for (std::size_t k = 0; k < components_; ++k) to[k * view_count_ + v] = from[v * components_ + k];
    });
    for (std::size_t i = 0; i < tileTexels() * components_; ++i) {
      Part block(coefficients + i * view_count_, shape_.views, shape_.views);
      block = (views_ * block * views_.transpose()).eval();
    }
    const auto row_size = static_cast<Eigen::Index>(a_texel_);
    for (int y = 0; y < tile_.height; ++y) {
      Part row(coefficients + static_cast<std::size_t>(y) * tile_.width * a_texel_, tile_.width, row_size);
      row = (across_ * row).eval();
    }
    Part all(coefficients, tile_.height, tile_.width * row_size);
    all = (down_ * all).eval();
  }

  // `highest_x` and `highest_y`: beyond these frequencies all coefficients are 0. `is_there`: of each block of views, whether it has any.
  void backward(float* coefficients, int highest_x, int highest_y, std::span<const std::uint8_t> is_there,
                std::span<float> values) const {
    for (std::size_t i = 0; i < is_there.size(); ++i) {
      if (is_there[i] == 0) continue;
      Part block(coefficients + i * view_count_, shape_.views, shape_.views);
      block = (views_.transpose() * block * views_).eval();
    }
    const auto row_size = static_cast<Eigen::Index>(a_texel_);
    for (int y = 0; y <= highest_y; ++y) {
      Part row(coefficients + static_cast<std::size_t>(y) * tile_.width * a_texel_, tile_.width, row_size);
      row = (across_.topRows(highest_x + 1).transpose() * row.topRows(highest_x + 1)).eval();
    }
    for (int x = 0; x < tile_.width; ++x) {
      Eigen::Map<Matrix, 0, Eigen::OuterStride<>> column(
          coefficients + static_cast<std::size_t>(x) * a_texel_, tile_.height, row_size,
          Eigen::OuterStride<>(tile_.width * row_size));
      column = (down_.topRows(highest_y + 1).transpose() * column.topRows(highest_y + 1)).eval();
    }
    forTexels([&](std::size_t texel, std::size_t place) {
      const float* from = coefficients + place * a_texel_;
      float* to = &values[texel * a_texel_];
      for (std::size_t v = 0; v < view_count_; ++v)
        for (std::size_t k = 0; k < components_; ++k) to[v * components_ + k] = from[k * view_count_ + v];
    });
  }

 private:
  std::size_t tileTexels() const { return static_cast<std::size_t>(tile_.width) * tile_.height; }
  template <class Visit>
  void forTexels(const Visit& visit) const {
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x)
        visit(static_cast<std::size_t>(tile_.y + y) * shape_.width + tile_.x + x,
              static_cast<std::size_t>(y) * tile_.width + x);
  }

  PatchValuesShape shape_;
  Tile tile_;
  Matrix views_, across_, down_;
  std::size_t view_count_ = static_cast<std::size_t>(shape_.views) * shape_.views,
              components_ = static_cast<std::size_t>(shape_.components), a_texel_ = view_count_ * components_;
};

std::int32_t levelOf(float coefficient, float step) {
  const float steps = std::abs(coefficient) / step;
  const auto level = static_cast<std::int32_t>(steps + (1 - kRounding));
  return coefficient < 0 ? -level : level;
}

// What is coded together, as it is alike: by what lies around.
constexpr std::size_t kClasses = 14;
enum Kind : std::size_t { kBlocks, kLevels, kKinds };  // whether a block has any; how large
using Streams = std::array<std::vector<std::uint32_t>, kKinds * kClasses>;

std::size_t classOf(std::uint32_t around) {
  return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(around)), kClasses - 1);
}

// Goes through the coefficients of a tile in the coder's order: rows, columns, components, of each a block of views; tells the class of
// each by those before it.
class TileWalk {
 public:
  TileWalk(const PatchValuesShape& shape, const Tile& tile)
      : shape_(shape),
        tile_(tile),
        block_size_(static_cast<std::size_t>(shape.views) * shape.views),
        levels(static_cast<std::size_t>(tile.width) * tile.height * shape.components * block_size_, 0),
        sums(levels.size() / block_size_, 0) {}

  // `block(class, index)` returns whether the block has any but zeros; then `level(class, index)` is called for each of it, and sets it.
  template <class Block, class Level>
  void run(const Block& block, const Level& level) {
    const std::size_t components = static_cast<std::size_t>(shape_.components),
                      views = static_cast<std::size_t>(shape_.views);
    for (int y = 0; y < tile_.height; ++y)
      for (int x = 0; x < tile_.width; ++x)
        for (std::size_t k = 0; k < components; ++k) {
          const std::size_t here = (static_cast<std::size_t>(y) * tile_.width + x) * components + k;
          // Blocks around: null for what is outside.
          const std::size_t row = static_cast<std::size_t>(tile_.width) * components;
          const std::array<std::pair<bool, std::size_t>, 7> around = {
              {{y > 0, here - row},
               {x > 0, here - components},
               {k > 0, here - 1},
               {x > 0 && y > 0, here - row - components},
               {y > 1, here - 2 * row},
               {x > 1, here - 2 * components},
               {k > 1, here - 2}}};
          std::uint32_t sum = 0;
          constexpr std::array<std::uint32_t, 7> kBlockWeights = {4, 4, 4, 2, 2, 2, 2};
          for (std::size_t i = 0; i < around.size(); ++i)
            if (around[i].first) sum += kBlockWeights[i] * std::min(sums[around[i].second], kMostCounted);
          if (!block(classOf(sum), here)) continue;
          constexpr std::array<std::uint32_t, 7> kWeights = {4, 4, 2, 2, 2, 2, 1};
          std::array<std::pair<std::uint32_t, const std::int32_t*>, 7> blocks;
          std::size_t count = 0;
          for (std::size_t i = 0; i < around.size(); ++i)
            if (around[i].first && sums[around[i].second] > 0)
              blocks[count++] = {kWeights[i], &levels[around[i].second * block_size_]};
          std::int32_t* const own = &levels[here * block_size_];
          std::uint32_t total = 0;
          for (std::size_t v = 0; v < block_size_; ++v) {
            std::uint32_t near = 0;
            for (std::size_t i = 0; i < count; ++i) near += blocks[i].first * counted(blocks[i].second[v]);
            if (v % views != 0) near += 4 * counted(own[v - 1]);
            if (v >= views) near += 4 * counted(own[v - views]);
            own[v] = level(classOf(near), here * block_size_ + v);
            total += counted(own[v]);
          }
          sums[here] = total;
        }
  }

 private:
  // Sums of what lies around must not overflow.
  static constexpr std::uint32_t kMostCounted = 1U << 20;
  static std::uint32_t counted(std::int32_t level) {
    return std::min(static_cast<std::uint32_t>(std::abs(level)), kMostCounted);
  }

  PatchValuesShape shape_;
  Tile tile_;
  std::size_t block_size_;

 public:
  std::vector<std::int32_t> levels;
  std::vector<std::uint32_t> sums;  // of the magnitudes of a block
};

// Draco counts in int.
constexpr std::size_t kMostSymbols = std::size_t{1} << 24;

}  // namespace

PatchEncoder::PatchEncoder(std::span<const float> values, const PatchValuesShape& shape)
    : shape_(shape), coefficients_(shape.count()) {
  if (values.size() != shape.count()) throw std::invalid_argument("values of a patch do not fit its shape");
  for (const Tile& tile : tilesOf(shape))
    TileTransform(shape, tile).forward(values, &coefficients_[tile.first]);
}

double PatchEncoder::squaredError(float step) const {
  double sum = 0;
  for (const float coefficient : coefficients_) {
    const double difference = double{coefficient} - static_cast<double>(step) * levelOf(coefficient, step);
    sum += difference * difference;
  }
  return sum;
}

float PatchEncoder::stepFor(double squared_error) const {
  float largest = 0;
  for (const float coefficient : coefficients_) largest = std::max(largest, std::abs(coefficient));
  if (largest == 0) return 1;
  // Errors grow with a power of the step that is between 0 and 2 and hardly changes: by secants of the logarithms, within a bracket.
  double fine = std::log(largest / kLargestLevel), coarse = std::log(2 * largest);
  double step =
      std::clamp(0.5 * std::log(4 * squared_error / static_cast<double>(coefficients_.size())), fine, coarse);
  const double target = std::log(squared_error);
  double last_step = 0, last_error = 0, power = 1.5;
  constexpr double kClose = 0.002;
  for (int i = 0; i < 40 && coarse - fine > kClose; ++i) {
    const double error = std::log(std::max(squaredError(static_cast<float>(std::exp(step))), 1e-300));
    (error <= target ? fine : coarse) = step;
    if (error <= target && target - error < kClose) break;
    if (i > 0 && std::abs(step - last_step) > 1e-9)
      power = std::clamp((error - last_error) / (step - last_step), 0.3, 3.0);
    last_step = step, last_error = error;
    step += (target - 0.4 * kClose - error) / power;
    if (step <= fine || step >= coarse) step = 0.5 * (fine + coarse);
  }
  return static_cast<float>(std::exp(fine));
}

Bytes PatchEncoder::encode(float step) const {
  Streams streams;
  std::vector<std::uint8_t> signs;
  std::size_t sign_count = 0;
  for (const Tile& tile : tilesOf(shape_)) {
    TileWalk walk(shape_, tile);
    const std::size_t block_size = static_cast<std::size_t>(shape_.views) * shape_.views;
    const float* coefficients = &coefficients_[tile.first];
    walk.run(
        [&](std::size_t near, std::size_t block) {
          const float* first = coefficients + block * block_size;
          const bool any =
              std::any_of(first, first + block_size, [&](float value) { return levelOf(value, step) != 0; });
          streams[kBlocks * kClasses + near].push_back(any ? 1 : 0);
          return any;
        },
        [&](std::size_t near, std::size_t index) {
          const std::int32_t level = levelOf(coefficients[index], step);
          streams[kLevels * kClasses + near].push_back(static_cast<std::uint32_t>(std::abs(level)));
          if (level != 0) {
            if (sign_count % 8 == 0) signs.push_back(0);
            if (level < 0) signs.back() |= static_cast<std::uint8_t>(1U << (sign_count % 8));
            ++sign_count;
          }
          return level;
        });
  }
  draco::EncoderBuffer buffer;
  for (const std::vector<std::uint32_t>& stream : streams) {
    buffer.Encode(static_cast<std::uint64_t>(stream.size()));
    for (std::size_t begin = 0; begin < stream.size(); begin += kMostSymbols) {
      const std::size_t count = std::min(kMostSymbols, stream.size() - begin);
      if (!draco::EncodeSymbols(stream.data() + begin, static_cast<int>(count), 1, nullptr, &buffer))
        throw std::logic_error("symbols that cannot be coded");
    }
  }
  buffer.Encode(static_cast<std::uint64_t>(sign_count));
  buffer.Encode(signs.data(), signs.size());
  const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
  return {bytes, bytes + buffer.size()};
}

namespace {

class StreamReader {
 public:
  StreamReader(std::span<const std::byte> bytes, std::size_t most, std::string file, std::string what)
      : file_(std::move(file)), what_(std::move(what)) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size(), DRACO_BITSTREAM_VERSION(2, 2));
    for (std::vector<std::uint32_t>& stream : streams_) {
      std::uint64_t count = 0;
      if (!buffer.Decode(&count) || count > most) throw broken();
      stream.resize(count);
      for (std::size_t begin = 0; begin < count; begin += kMostSymbols) {
        const auto block = static_cast<std::uint32_t>(std::min<std::size_t>(kMostSymbols, count - begin));
        if (!draco::DecodeSymbols(block, 1, &buffer, stream.data() + begin)) throw broken();
      }
    }
    std::uint64_t signs = 0;
    if (!buffer.Decode(&signs) || signs > most ||
        static_cast<std::uint64_t>(buffer.remaining_size()) != (signs + 7) / 8)
      throw broken();
    sign_count_ = signs;
    const auto* first = reinterpret_cast<const std::uint8_t*>(buffer.data_head());
    signs_.assign(first, first + (signs + 7) / 8);
  }

  std::uint32_t next(Kind kind, std::size_t near) {
    const std::size_t stream = kind * kClasses + near;
    if (next_[stream] == streams_[stream].size()) throw broken();
    return streams_[stream][next_[stream]++];
  }
  bool nextSign() {
    if (next_sign_ == sign_count_) throw broken();
    const bool negative = (signs_[next_sign_ / 8] >> (next_sign_ % 8) & 1) != 0;
    ++next_sign_;
    return negative;
  }
  void requireEnd() const {
    for (std::size_t i = 0; i < streams_.size(); ++i)
      if (next_[i] != streams_[i].size()) throw broken();
    if (next_sign_ != sign_count_) throw broken();
  }
  Error broken() const {
    return badInput({file_, what_, ""}, "the code is not one of a patch of this size", "what pack wrote",
                    "make the pack again");
  }

 private:
  std::string file_, what_;
  Streams streams_;
  std::array<std::size_t, kKinds* kClasses> next_ = {};
  std::vector<std::uint8_t> signs_;
  std::size_t sign_count_ = 0, next_sign_ = 0;
};

}  // namespace

std::vector<float> decodePatchValues(std::span<const std::byte> bytes, float step,
                                     const PatchValuesShape& shape, const std::string& file,
                                     const std::string& what) {
  StreamReader reader(bytes, shape.count(), file, what);
  std::vector<float> values(shape.count()), coefficients;
  for (const Tile& tile : tilesOf(shape)) {
    TileWalk walk(shape, tile);
    std::vector<std::uint8_t> is_there(walk.sums.size(), 0);
    int highest_x = 0, highest_y = 0;
    walk.run(
        [&](std::size_t near, std::size_t block) {
          if (reader.next(kBlocks, near) == 0) return false;
          is_there[block] = 1;
          const auto texel = static_cast<int>(block / static_cast<std::size_t>(shape.components));
          highest_x = std::max(highest_x, texel % tile.width),
          highest_y = std::max(highest_y, texel / tile.width);
          return true;
        },
        [&](std::size_t near, std::size_t) {
          const std::uint32_t magnitude = reader.next(kLevels, near);
          if (magnitude > static_cast<std::uint32_t>(kLargestLevel) * 2) throw reader.broken();
          if (magnitude == 0) return std::int32_t{0};
          const auto level = static_cast<std::int32_t>(magnitude);
          return reader.nextSign() ? -level : level;
        });
    coefficients.resize(walk.levels.size());
    for (std::size_t i = 0; i < coefficients.size(); ++i)
      coefficients[i] = step * static_cast<float>(walk.levels[i]);
    TileTransform(shape, tile).backward(coefficients.data(), highest_x, highest_y, is_there, values);
  }
  reader.requireEnd();
  return values;
}

void expandPatch(FactoredPatch& patch, const std::string& file) {
  if (!patch.code) return;
  const PatchCode& code = *patch.code;
  const std::size_t views = static_cast<std::size_t>(patch.views) * patch.views,
                    components = static_cast<std::size_t>(patch.components);
  const PatchValuesShape shape{patch.width, patch.height, patch.views, patch.components};
  const std::vector<float> factors =
      withLevels(decodePatchValues(code.factors.data, code.step, shape, file, "factorCode"), patch.width,
                 patch.height, views * components);
  constexpr const char* kWhat = "factors of the patch";
  patch.factors = code.precision == Precision::kUint8
                      ? encodeSigned(factors, components, file, kWhat)
                      : encodeTable(factors, components, code.precision, file, kWhat);
  patch.heights.reset();
  if (code.relief) {
    const PatchValuesShape one{patch.width, patch.height, patch.views, 1};
    patch.heights = encodeTable(
        withLevels(decodePatchValues(code.relief->heights.data, code.relief->step, one, file, "heightCode"),
                   patch.width, patch.height, views),
        1, Precision::kFloat16, file, "heights of the patch");
  }
}

}  // namespace bakelight::formats
