#include "formats/btf_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <Eigen/Core>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "formats/atomic_file.h"
#include "formats/error.h"
#include "formats/file.h"

namespace bakelight::formats {
namespace {

constexpr float kLargestHalf = 65504;
constexpr std::size_t kSetupLength = 80, kBtfSignatureLength = 10;

class Part {
 public:
  template <class T>
  void add(const T& value) {
    const auto bytes = std::as_bytes(std::span(&value, 1));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  void addCount(std::size_t value) { add(static_cast<std::uint32_t>(value)); }
  void addText(std::string_view text, std::size_t length) {
    for (std::size_t i = 0; i < length; ++i) add(i < text.size() ? text[i] : '\0');
  }
  void addDirection(const BtfDirection& direction) {
    add(static_cast<float>(direction.polar_rad));
    add(static_cast<float>(direction.azimuth_rad));
  }
  const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
};

// Appends parts.
class Writer {
 public:
  explicit Writer(const std::filesystem::path& path) : file_(path) {}
  void write(std::span<const std::byte> bytes) {
    file_.writeAt(offset_, bytes);
    offset_ += bytes.size();
  }
  void finish() { file_.finish(); }

 private:
  AtomicFile file_;
  std::uint64_t offset_ = 0;
};

// Version 4: channels by name.
void addMeta(Part& part, const BtfInfo& info) {
  constexpr std::uint32_t kVersion = 4;
  Part meta;
  meta.add(kVersion);
  for (const std::string* text : {&info.measurement_setup, &info.image_sensor, &info.light_source})
    meta.addText(*text, kSetupLength);
  meta.add(static_cast<float>(info.texels_per_mm));
  meta.add(info.rgb_scale);
  meta.addCount(info.cosine_inside ? 1 : 0);
  meta.addCount(0);  // XML
  meta.addCount(3);
  for (const char* name : {"R", "G", "B"}) {
    meta.addCount(1);
    meta.addText(name, 1);
  }
  part.addCount(meta.bytes().size() + sizeof(std::uint32_t));
  for (const std::byte byte : meta.bytes()) part.add(byte);
}

void addSampling(Part& part, const BtfInfo& info) {
  part.addCount(info.views.size());
  for (const BtfDirection& view : info.views) {
    part.addDirection(view);
    part.addCount(info.lights.size());
    for (const BtfDirection& light : info.lights) part.addDirection(light);
  }
  part.addCount(static_cast<std::size_t>(info.width));
  part.addCount(static_cast<std::size_t>(info.height));
}

Bytes encoded(std::span<const float> values, BtfPrecision precision, const std::string& file,
              const std::string& what) {
  for (const float value : values) {
    if (std::isfinite(value) && (precision == BtfPrecision::kFloat || std::abs(value) <= kLargestHalf))
      continue;
    throw badInput({file, what, ""}, std::to_string(value) + " does not fit a half float", "-65504 to 65504",
                   "write floats");
  }
  const auto bytes = std::as_bytes(values);
  if (precision == BtfPrecision::kFloat) return {bytes.begin(), bytes.end()};
  std::vector<Eigen::half> halves(values.size());
  std::ranges::transform(values, halves.begin(), [](float value) { return Eigen::half(value); });
  const auto half_bytes = std::as_bytes(std::span(halves));
  return {half_bytes.begin(), half_bytes.end()};
}

}  // namespace

void writeFactorizedBtf(const std::filesystem::path& path, const BtfInfo& info, BtfColorModel model,
                        const std::vector<BtfFactors>& channels, BtfPrecision precision) {
  const std::size_t directions = info.views.size() * info.lights.size();
  const std::size_t texels = static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height);
  std::size_t largest_rank = 0;
  for (const BtfFactors& factors : channels) {
    largest_rank = std::max(largest_rank, factors.rank);
    if (factors.singular_values.size() != factors.rank ||
        factors.directions.size() != directions * factors.rank ||
        factors.texels.size() != texels * factors.rank || channels.size() != 3)
      throw std::logic_error("the factors of a BTF have other sizes than it says");
  }
  Part part;
  part.addText("!DFMF08FCR", kBtfSignatureLength);
  addMeta(part, info);
  addSampling(part, info);
  part.addCount(0);  // rotations
  part.addCount(largest_rank);
  part.add(static_cast<std::int32_t>(model));
  part.add(std::array<float, 3>{});
  part.add(BtfMatrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
  Writer writer(path);
  writer.write(part.bytes());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const BtfFactors& factors = channels[c];
    const std::string what = "channel " + std::to_string(c);
    Part sizes;
    sizes.add(static_cast<std::uint8_t>(precision == BtfPrecision::kHalf ? 2 : 4));
    for (const std::size_t size : {factors.rank, directions, texels}) sizes.addCount(size);
    writer.write(sizes.bytes());
    for (const std::vector<float>* values : {&factors.singular_values, &factors.directions, &factors.texels})
      writer.write(encoded(*values, precision, path.string(), what));
  }
  writer.finish();
}

void writeRawBtf(const std::filesystem::path& path, const Btf& btf) {
  const BtfInfo& info = btf.info();
  const auto width = static_cast<std::size_t>(info.width), height = static_cast<std::size_t>(info.height);
  const std::size_t lights = info.lights.size(), row = width * info.views.size() * lights * 3;
  if (2 * row > UINT32_MAX)
    throw badInput({path.string(), "", ""}, "a row of texels has more bytes than the layout can say",
                   "less than 4 GiB", "write it factorised, or crop it");
  std::vector<std::shared_ptr<const BtfView>> views;
  const std::vector<int> all = btf.Btf::lightsOf(0);
  for (std::size_t v = 0; v < info.views.size(); ++v) {
    if (btf.lightsOf(static_cast<int>(v)).size() != lights)
      throw badInput({info.file, "view " + std::to_string(v), ""}, "pictures under some lights are missing",
                     "all of them: a .btf has no gaps");
    views.push_back(btf.view(static_cast<int>(v)));
  }
  Part part;
  part.addText("!BDIF06R2!", kBtfSignatureLength);
  addMeta(part, info);
  addSampling(part, info);
  part.addCount(1);  // scan lines of a chunk
  part.add(std::uint8_t{0});
  for (std::size_t t = 0; t < width * height; ++t) part.add(std::uint8_t{1});
  part.addCount(0);  // rotations
  Writer writer(path);
  writer.write(part.bytes());
  std::vector<float> values(row), rgb(3 * lights * width);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t v = 0; v < views.size(); ++v) {
      views[v]->decode(all, {y * width, width}, rgb);
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t l = 0; l < lights; ++l)
          for (std::size_t x = 0; x < width; ++x)
            values[((x * views.size() + v) * lights + l) * 3 + c] = rgb[(c * lights + l) * width + x];
    }
    Part size;
    size.addCount(2 * row);
    writer.write(size.bytes());
    writer.write(encoded(values, BtfPrecision::kHalf, path.string(), "row " + std::to_string(y)));
  }
  writer.finish();
}

}  // namespace bakelight::formats
