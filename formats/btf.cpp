#include "formats/btf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include "formats/btf_bodies.h"
#include "formats/btf_header.h"
#include "formats/error.h"
#include "formats/mapped_file.h"

namespace bakelight::formats {
namespace {

class TableView : public BtfView {
 public:
  TableView(std::shared_ptr<const BtfInfo> info, int view, std::shared_ptr<const std::vector<float>> values)
      : BtfView(std::move(info), view), values_(std::move(values)) {}

 private:
  void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const override {
    const std::size_t all = static_cast<std::size_t>(info().width) * info().height;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const std::size_t picture = static_cast<std::size_t>(index()) * info().lights.size() + lights[i];
      const float* from = values_->data() + 3 * (picture * all + texels.first);
      for (std::size_t t = 0; t < texels.count; ++t)
        for (std::size_t c = 0; c < 3; ++c) rgb[(c * lights.size() + i) * texels.count + t] = from[3 * t + c];
    }
  }

  std::shared_ptr<const std::vector<float>> values_;
};

class TableBtf : public Btf {
 public:
  TableBtf(BtfInfo info, std::vector<float> values)
      : Btf(std::move(info)), values_(std::make_shared<const std::vector<float>>(std::move(values))) {}
  std::shared_ptr<const BtfView> view(int view) const override {
    return std::make_shared<TableView>(sharedInfo(), view, values_);
  }

 private:
  std::shared_ptr<const std::vector<float>> values_;
};

}  // namespace

void BtfView::decode(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const {
  if (rgb.size() != 3 * lights.size() * texels.count)
    throw std::logic_error("BtfView::decode: sizes do not fit");
  decodeValues(lights, texels, rgb);
  // Infinities and NaN are all that is not equal to itself times nought… and one sum finds them.
  float sum = 0;
  for (const float value : rgb) sum += value * 0.0F;
  if (sum == 0) return;
  const auto bad = std::ranges::find_if_not(rgb, [](float value) { return std::isfinite(value); });
  const auto place = static_cast<std::size_t>(bad - rgb.begin());
  const std::size_t texel = texels.first + place % texels.count;
  const int light = lights[place / texels.count % lights.size()];
  const auto width = static_cast<std::size_t>(info_->width);
  throw badInput({info_->file,
                  "view " + std::to_string(view_) + ", light " + std::to_string(light) + ", texel (" +
                      std::to_string(texel % width) + ", " + std::to_string(texel / width) + ")",
                  ""},
                 "its value is not finite", "a number", "the file is damaged: fetch it again");
}

std::vector<int> Btf::lightsOf(int /*view*/) const {
  std::vector<int> lights(info().lights.size());
  std::iota(lights.begin(), lights.end(), 0);
  return lights;
}

std::unique_ptr<Btf> btfOf(BtfInfo info, std::vector<float> values) {
  const std::size_t expected = 3 * info.views.size() * info.lights.size() *
                               static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height);
  if (values.size() != expected || values.empty())
    throw std::logic_error("a BTF has another number of values than it says");
  if (info.layout.empty()) info.layout = "table";
  return std::make_unique<TableBtf>(std::move(info), std::move(values));
}

bool isBtfFile(const std::filesystem::path& path) {
  if (!std::filesystem::is_regular_file(path)) return false;
  std::ifstream file(path, std::ios::binary);
  std::array<char, kLongestBtfSignature> begin = {};
  file.read(begin.data(), begin.size());
  return btfSignatureOf(std::as_bytes(std::span(begin).first(static_cast<std::size_t>(file.gcount())))) !=
         nullptr;
}

std::unique_ptr<Btf> openBtf(const std::filesystem::path& path) {
  const auto file = MappedFile::open(path);
  BtfCursor cursor(file->bytes(), path.string());
  const BtfSignature* signature = btfSignatureOf(file->bytes());
  if (signature == nullptr)
    throw badInput({path.string(), "offset 0", ""}, "it does not begin as a BTF of the University of Bonn",
                   "!DFMF08FCR, !FMF12FCER, !FMF06FCR, !FMF06FC, !PVF06FCR, !PVF06FC or !BDIF06R2!",
                   "check that the download is whole");
  cursor.take(std::string_view(signature->text).size(), "the signature");
  OpenedBtf opened{file, *signature, cursor};
  switch (signature->layout) {
    case BtfLayout::kDecorrelated:
      return openDecorrelatedBtf(std::move(opened));
    case BtfLayout::kFullMatrix:
      return openFullMatrixBtf(std::move(opened));
    case BtfLayout::kPerView:
      return openPerViewBtf(std::move(opened));
    case BtfLayout::kRaw:
      break;
  }
  return openRawBtf(std::move(opened));
}

}  // namespace bakelight::formats
