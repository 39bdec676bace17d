#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/btf_bodies.h"
#include "formats/btf_color.h"
#include "formats/btf_scalars.h"

namespace bakelight::formats {
namespace {

constexpr std::uint64_t kMissing = UINT64_MAX;
enum class Compression : std::uint8_t { kNone = 0, kBzip = 1, kSparse = 2 };

struct Values {
  std::shared_ptr<const MappedFile> file;
  std::vector<std::span<const std::byte>> chunks;
  std::uint64_t texels_a_chunk = 0, texel_bytes = 0;
  std::vector<std::uint64_t> place;  // of each texel among those that are there; empty: its own
  BtfColors colors;
};

class RawView : public BtfView {
 public:
  RawView(std::shared_ptr<const BtfInfo> info, int view, std::shared_ptr<const Values> values)
      : BtfView(std::move(info), view), values_(std::move(values)) {}

 private:
  void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const override {
    const std::size_t channels = values_->colors.channelCount(), pixels = lights.size() * texels.count;
    const std::size_t first = static_cast<std::size_t>(index()) * info().lights.size();
    std::vector<float> planes(channels * pixels);
    for (std::size_t t = 0; t < texels.count; ++t) {
      const std::size_t texel = texels.first + t;
      const std::uint64_t place = values_->place.empty() ? texel : values_->place[texel];
      if (place == kMissing) continue;
      const std::byte* from = values_->chunks[place / values_->texels_a_chunk].data() +
                              place % values_->texels_a_chunk * values_->texel_bytes;
      for (std::size_t i = 0; i < lights.size(); ++i)
        for (std::size_t c = 0; c < channels; ++c) {
          std::uint16_t bits;
          std::memcpy(&bits, from + 2 * ((first + static_cast<std::size_t>(lights[i])) * channels + c), 2);
          planes[c * pixels + i * texels.count + t] =
              static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
        }
    }
    values_->colors.toRgb(planes, pixels, rgb);
  }

  std::shared_ptr<const Values> values_;
};

class RawBtf : public Btf {
 public:
  RawBtf(BtfInfo info, Values values)
      : Btf(std::move(info)), values_(std::make_shared<const Values>(std::move(values))) {}
  std::shared_ptr<const BtfView> view(int view) const override {
    return std::make_shared<RawView>(sharedInfo(), view, values_);
  }

 private:
  std::shared_ptr<const Values> values_;
};

Compression readCompression(BtfCursor& cursor) {
  const std::uint64_t offset = cursor.offset();
  const auto compression = cursor.read<std::uint8_t>("the compression");
  if (compression == static_cast<std::uint8_t>(Compression::kBzip))
    throw cursor.error("its chunks are compressed by bzip", "0 (none) or 2 (sparse)", offset,
                       "write it again without, for example with btflib");
  if (compression > static_cast<std::uint8_t>(Compression::kSparse))
    throw cursor.error("the compression is " + std::to_string(compression), "0 (none) or 2 (sparse)", offset);
  return static_cast<Compression>(compression);
}

// How many texels are there; fills `place` if some are not.
std::uint64_t placeTexels(std::span<const std::byte> mask, std::vector<std::uint64_t>& place) {
  std::uint64_t stored = 0;
  place.resize(mask.size());
  for (std::size_t t = 0; t < mask.size(); ++t) place[t] = mask[t] != std::byte{0} ? stored++ : kMissing;
  if (stored == mask.size()) place.clear();
  return stored;
}

}  // namespace

std::unique_ptr<Btf> openRawBtf(OpenedBtf opened) {
  BtfCursor& cursor = opened.cursor;
  BtfHeader header;
  BtfInfo& info = header.info;
  readBtfMeta(cursor, header);
  readBtfSampling(cursor, info);
  readBtfSize(cursor, info);
  const std::uint64_t lines_offset = cursor.offset();
  const std::uint32_t lines = cursor.readCount("the scan lines of a chunk");
  if (lines == 0) throw cursor.error("a chunk has no scan lines", "one or more", lines_offset);
  const Compression compression = readCompression(cursor);
  const auto mask = cursor.take(
      saturatedProduct({static_cast<std::uint64_t>(info.width), static_cast<std::uint64_t>(info.height)}),
      "the mask of texels");
  readBtfRotations(cursor, info);

  Values values;
  values.colors = BtfColors(cursor, 0, header.channels, {}, {}, false);
  values.texel_bytes = saturatedProduct({2, header.channels.size(), info.views.size(), info.lights.size()});
  values.texels_a_chunk = saturatedProduct({static_cast<std::uint64_t>(info.width), lines});
  const std::uint64_t stored =
      compression == Compression::kSparse ? placeTexels(mask, values.place) : mask.size();
  for (std::uint64_t begin = 0; begin < stored; begin += values.texels_a_chunk) {
    const std::string what = "chunk " + std::to_string(values.chunks.size());
    const std::uint64_t expected =
        saturatedProduct({std::min(values.texels_a_chunk, stored - begin), values.texel_bytes});
    const std::uint64_t offset = cursor.offset();
    const std::uint32_t size = cursor.readCount("the size of " + what);
    if (size != expected)
      throw cursor.error(what + " has " + std::to_string(size) + " bytes", std::to_string(expected), offset);
    values.chunks.push_back(cursor.take(size, what));
  }
  cursor.requireEnd();
  if (stored < mask.size())
    info.notes.push_back(std::to_string(mask.size() - stored) + " texels were not measured: they are black");
  info.file = cursor.file();
  info.layout = "BDI";
  info.bytes = opened.file->bytes().size();
  const auto& notes = values.colors.notes();
  info.notes.insert(info.notes.end(), notes.begin(), notes.end());
  values.file = std::move(opened.file);
  return std::make_unique<RawBtf>(std::move(info), std::move(values));
}

}  // namespace bakelight::formats
