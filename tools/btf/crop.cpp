#include "tools/btf/crop.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "formats/error.h"

namespace bakelight::btf {
namespace {

using formats::BtfTexels;

struct Frame {
  std::size_t left, top, source_width, shrink;
};

class CroppedView : public formats::BtfView {
 public:
  CroppedView(std::shared_ptr<const formats::BtfInfo> info, int view,
              std::shared_ptr<const formats::BtfView> source, const Frame& frame)
      : BtfView(std::move(info), view), source_(std::move(source)), frame_(frame) {}

 private:
  void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const override {
    const auto width = static_cast<std::size_t>(info().width);
    const std::size_t shrink = frame_.shrink;
    std::ranges::fill(rgb, 0.0F);
    const float share = 1 / static_cast<float>(shrink * shrink);
    for (std::size_t done = 0; done < texels.count;) {
      const std::size_t texel = texels.first + done, x = texel % width, y = texel / width;
      const std::size_t count = std::min(width - x, texels.count - done);
      std::vector<float> row(3 * lights.size() * count * shrink);
      for (std::size_t line = 0; line < shrink; ++line) {
        source_->decode(lights,
                        {(frame_.top + y * shrink + line) * frame_.source_width + frame_.left + x * shrink,
                         count * shrink},
                        row);
        for (std::size_t plane = 0; plane < 3 * lights.size(); ++plane)
          for (std::size_t i = 0; i < count * shrink; ++i)
            rgb[plane * texels.count + done + i / shrink] += share * row[plane * count * shrink + i];
      }
      done += count;
    }
  }

  std::shared_ptr<const formats::BtfView> source_;
  Frame frame_;
};

class CroppedBtf : public formats::Btf {
 public:
  CroppedBtf(formats::BtfInfo info, std::shared_ptr<const formats::Btf> source, const Frame& frame)
      : Btf(std::move(info)), source_(std::move(source)), frame_(frame) {}
  std::vector<int> lightsOf(int view) const override { return source_->lightsOf(view); }
  std::shared_ptr<const formats::BtfView> view(int view) const override {
    return std::make_shared<CroppedView>(sharedInfo(), view, source_->view(view), frame_);
  }

 private:
  std::shared_ptr<const formats::Btf> source_;
  Frame frame_;
};

}  // namespace

std::shared_ptr<const formats::Btf> cropped(std::shared_ptr<const formats::Btf> btf, const Crop& crop,
                                            int* dropped) {
  formats::BtfInfo info = btf->info();
  const int right = crop.width > 0 ? std::min(crop.left + crop.width, info.width) : info.width;
  const int bottom = crop.height > 0 ? std::min(crop.top + crop.height, info.height) : info.height;
  const int width = (right - crop.left) / crop.shrink, height = (bottom - crop.top) / crop.shrink;
  if (width < 1 || height < 1 || crop.left < 0 || crop.top < 0)
    throw badInput({info.file, "", ""},
                   "nothing is left of its " + std::to_string(info.width) + " × " +
                       std::to_string(info.height) + " texels",
                   "a crop within them", "crop less, or average fewer");
  if (dropped != nullptr)
    *dropped = (right - crop.left) * (bottom - crop.top) - width * height * crop.shrink * crop.shrink;
  const Frame frame{static_cast<std::size_t>(crop.left), static_cast<std::size_t>(crop.top),
                    static_cast<std::size_t>(info.width), static_cast<std::size_t>(crop.shrink)};
  if (width == info.width && height == info.height) return btf;
  info.width = width, info.height = height;
  info.texels_per_mm /= crop.shrink;
  return std::make_shared<CroppedBtf>(std::move(info), std::move(btf), frame);
}

}  // namespace bakelight::btf
