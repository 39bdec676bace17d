#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/btf_bodies.h"
#include "formats/btf_color.h"
#include "formats/btf_scalars.h"

namespace bakelight::formats {
namespace {

constexpr std::int32_t kOldBody = 301074;

// mean + components · weightsᵀ, channels fastest in the first; they are beside lights, or beside texels.
struct ViewFactors {
  BtfScalars mean, components, weights;
};

struct ViewMatrices {
  std::shared_ptr<const MappedFile> file;
  std::vector<ViewFactors> views;
  bool components_are_of_lights = true;
  BtfColors colors;
};

class PerViewView : public BtfView {
 public:
  PerViewView(std::shared_ptr<const BtfInfo> info, int view, std::shared_ptr<const ViewMatrices> matrices)
      : BtfView(std::move(info), view), matrices_(std::move(matrices)) {}

 private:
  void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const override {
    const ViewFactors& factors = matrices_->views[static_cast<std::size_t>(index())];
    const std::size_t channels = matrices_->colors.channelCount(), pixels = lights.size() * texels.count;
    const bool of_lights = matrices_->components_are_of_lights;
    const auto light = [&](std::size_t i) { return static_cast<std::size_t>(lights[i]); };
    const auto texel = [&](std::size_t t) { return texels.first + t; };
    const BtfRows weights =
        of_lights ? factors.weights.rows(texels.count, texel) : factors.weights.rows(lights.size(), light);
    std::vector<float> planes(channels * pixels);
    for (std::size_t c = 0; c < channels; ++c) {
      const auto channelOf = [&](const auto& place) {
        return [&, c](std::size_t i) { return channels * place(i) + c; };
      };
      Eigen::Map<BtfRows> plane(planes.data() + c * pixels, static_cast<Eigen::Index>(lights.size()),
                                static_cast<Eigen::Index>(texels.count));
      if (of_lights)
        plane.noalias() = factors.components.rows(lights.size(), channelOf(light)) * weights.transpose();
      else
        plane.noalias() = weights * factors.components.rows(texels.count, channelOf(texel)).transpose();
      for (std::size_t i = 0; i < lights.size(); ++i)
        for (std::size_t t = 0; t < texels.count; ++t)
          plane(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(t)) +=
              factors.mean.at(0, channels * (of_lights ? light(i) : texel(t)) + c);
    }
    matrices_->colors.toRgb(planes, pixels, rgb);
  }

  std::shared_ptr<const ViewMatrices> matrices_;
};

class PerViewBtf : public Btf {
 public:
  PerViewBtf(BtfInfo info, ViewMatrices matrices)
      : Btf(std::move(info)), matrices_(std::make_shared<const ViewMatrices>(std::move(matrices))) {}
  std::shared_ptr<const BtfView> view(int view) const override {
    return std::make_shared<PerViewView>(sharedInfo(), view, matrices_);
  }

 private:
  std::shared_ptr<const ViewMatrices> matrices_;
};

// Returns the number of views that have a factorisation.
std::uint32_t readPerViewHeader(BtfCursor& cursor, const BtfSignature& signature, BtfHeader& header) {
  BtfCursor ahead = cursor;
  if (ahead.read<std::int32_t>("the meta data") != kOldBody) {
    readBtfHeader(cursor, signature, header);
    cursor.readCount("the number of components");
    return cursor.readCount("the number of views with factors");
  }
  cursor = ahead;
  header.channels = {"R", "G", "B"};
  header.info.cosine_inside = false;
  cursor.readCount("the number of components");
  readBtfSize(cursor, header.info);
  const std::uint32_t slots = cursor.readCount("the number of views with factors");
  readBtfSampling(cursor, header.info);
  return slots;
}

}  // namespace

std::unique_ptr<Btf> openPerViewBtf(OpenedBtf opened) {
  BtfCursor& cursor = opened.cursor;
  BtfHeader header;
  BtfInfo& info = header.info;
  const std::uint32_t slots = readPerViewHeader(cursor, opened.signature, header);
  if (slots != info.views.size())
    throw cursor.error("there are factors of " + std::to_string(slots) + " views",
                       std::to_string(info.views.size()) + ", one set for each view");
  ViewMatrices matrices;
  matrices.colors = BtfColors(cursor, 0, header.channels, {}, {}, false);
  const std::uint64_t channels = header.channels.size(), lights = info.lights.size();
  const std::uint64_t texels =
      static_cast<std::uint64_t>(info.width) * static_cast<std::uint64_t>(info.height);
  for (std::uint32_t v = 0; v < slots; ++v) {
    const std::string of_view = " of view " + std::to_string(v);
    const std::uint64_t offset = cursor.offset();
    const BtfScalar scalar = readBtfScalar(cursor);
    const std::uint64_t rank = cursor.readCount("the number of components" + of_view);
    const std::uint64_t weights = cursor.readCount("the number of weights" + of_view);
    const std::uint64_t dimension = cursor.readCount("the dimension" + of_view);
    const bool of_lights = dimension == channels * lights && weights == texels;
    if (!of_lights && !(dimension == channels * texels && weights == lights))
      throw cursor.error("view " + std::to_string(v) + " has " + std::to_string(weights) +
                             " weights of components of " + std::to_string(dimension) + " numbers",
                         std::to_string(texels) + " texels by " + std::to_string(channels) + " · " +
                             std::to_string(lights) + " lights, or the other way round",
                         offset);
    if (v > 0 && of_lights != matrices.components_are_of_lights)
      throw cursor.error("the factors" + of_view + " lie the other way round", "as those of view 0", offset);
    matrices.components_are_of_lights = of_lights;
    cursor.take(saturatedProduct({rank, static_cast<std::uint64_t>(scalar)}), "the eigenvalues" + of_view);
    ViewFactors factors;
    factors.mean = BtfScalars(cursor, scalar, 1, dimension, "the mean" + of_view);
    factors.components = BtfScalars(cursor, scalar, dimension, rank, "the components" + of_view);
    factors.weights = BtfScalars(cursor, scalar, weights, rank, "the weights" + of_view);
    matrices.views.push_back(factors);
  }
  cursor.requireEnd();
  info.file = cursor.file();
  info.layout = "PVF";
  info.bytes = opened.file->bytes().size();
  const auto& notes = matrices.colors.notes();
  info.notes.insert(info.notes.end(), notes.begin(), notes.end());
  matrices.file = std::move(opened.file);
  return std::make_unique<PerViewBtf>(std::move(info), std::move(matrices));
}

}  // namespace bakelight::formats
