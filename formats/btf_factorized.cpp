#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/btf_bodies.h"
#include "formats/btf_color.h"
#include "formats/btf_scalars.h"

namespace bakelight::formats {
namespace {

// left · rightᵀ
struct Factors {
  BtfScalars left, right;
  std::uint64_t left_rows = 0, right_rows = 0;
};

Factors readFactors(BtfCursor& cursor) {
  Factors factors;
  const BtfScalar scalar = readBtfScalar(cursor);
  const std::uint32_t rank = cursor.readCount("the number of components");
  factors.left_rows = cursor.readCount("the number of rows");
  factors.right_rows = cursor.readCount("the number of columns");
  cursor.take(saturatedProduct({rank, static_cast<std::uint64_t>(scalar)}), "the singular values");
  factors.left = BtfScalars(cursor, scalar, factors.left_rows, rank, "the left singular vectors");
  factors.right = BtfScalars(cursor, scalar, factors.right_rows, rank, "the right singular vectors");
  return factors;
}

struct Sizes {
  std::uint64_t channels, directions, texels;
};

Sizes sizesOf(const BtfHeader& header) {
  return {header.channels.size(), saturatedProduct({header.info.views.size(), header.info.lights.size()}),
          saturatedProduct({static_cast<std::uint64_t>(header.info.width),
                            static_cast<std::uint64_t>(header.info.height)})};
}

// Whether rows are directions; throws if they are neither those nor texels. `direction_rows` and `texel_rows`: how
// many of either a direction and a texel have.
bool directionsAreRows(const BtfCursor& cursor, const Factors& factors, const Sizes& sizes,
                       std::uint64_t channels, std::uint64_t offset) {
  if (factors.left_rows == channels * sizes.directions && factors.right_rows == sizes.texels) return true;
  if (factors.left_rows == channels * sizes.texels && factors.right_rows == sizes.directions) return false;
  const std::string each = channels > 1 ? std::to_string(channels) + " · " : "";
  throw cursor.error("a matrix has " + std::to_string(factors.left_rows) + " rows and " +
                         std::to_string(factors.right_rows) + " columns",
                     each + std::to_string(sizes.directions) + " pairs of directions by " +
                         std::to_string(sizes.texels) + " texels, or " + each +
                         "texels by pairs of directions",
                     offset);
}

// What a view needs of its file.
struct Matrices {
  std::shared_ptr<const MappedFile> file;
  std::vector<Factors> factors;  // of each channel, or one of all
  bool directions_are_rows = true;
  BtfColors colors;
};

class FactorizedView : public BtfView {
 public:
  FactorizedView(std::shared_ptr<const BtfInfo> info, int view, std::shared_ptr<const Matrices> matrices)
      : BtfView(std::move(info), view), matrices_(std::move(matrices)) {}

 private:
  void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const override {
    const std::size_t channels = matrices_->colors.channelCount(), pixels = lights.size() * texels.count;
    const bool is_one = matrices_->factors.size() == 1;  // of all channels, which lie beside the left's rows
    const std::size_t stride = is_one ? channels : 1;
    const std::size_t first = static_cast<std::size_t>(index()) * info().lights.size();
    std::vector<float> planes(channels * pixels);
    for (std::size_t c = 0; c < channels; ++c) {
      const Factors& factors = matrices_->factors[is_one ? 0 : c];
      const std::size_t offset = is_one ? c : 0;
      const auto direction = [&](std::size_t i) { return first + static_cast<std::size_t>(lights[i]); };
      const auto texel = [&](std::size_t t) { return texels.first + t; };
      const auto leftOf = [&](const auto& place) {
        return [&, stride, offset](std::size_t i) { return stride * place(i) + offset; };
      };
      const bool rows = matrices_->directions_are_rows;
      const BtfRows of_directions = rows ? factors.left.rows(lights.size(), leftOf(direction))
                                         : factors.right.rows(lights.size(), direction);
      const BtfRows of_texels =
          rows ? factors.right.rows(texels.count, texel) : factors.left.rows(texels.count, leftOf(texel));
      Eigen::Map<BtfRows>(planes.data() + c * pixels, static_cast<Eigen::Index>(lights.size()),
                          static_cast<Eigen::Index>(texels.count))
          .noalias() = of_directions * of_texels.transpose();
    }
    matrices_->colors.toRgb(planes, pixels, rgb);
  }

  std::shared_ptr<const Matrices> matrices_;
};

class FactorizedBtf : public Btf {
 public:
  FactorizedBtf(BtfInfo info, Matrices matrices)
      : Btf(std::move(info)), matrices_(std::make_shared<const Matrices>(std::move(matrices))) {}
  std::shared_ptr<const BtfView> view(int view) const override {
    return std::make_shared<FactorizedView>(sharedInfo(), view, matrices_);
  }

 private:
  std::shared_ptr<const Matrices> matrices_;
};

std::unique_ptr<Btf> factorized(OpenedBtf opened, BtfHeader header, Matrices matrices, const char* layout) {
  opened.cursor.requireEnd();
  BtfInfo& info = header.info;
  info.file = opened.cursor.file();
  info.layout = layout;
  info.bytes = opened.file->bytes().size();
  const auto& notes = matrices.colors.notes();
  info.notes.insert(info.notes.end(), notes.begin(), notes.end());
  matrices.file = std::move(opened.file);
  return std::make_unique<FactorizedBtf>(std::move(info), std::move(matrices));
}

// If the body has one: version, how the dynamic range was reduced, heights. Whether values are logarithms.
bool readExtension(BtfCursor& cursor, BtfInfo& info) {
  const std::uint64_t offset = cursor.offset();
  const auto version = cursor.read<std::uint8_t>("the version of the extended header");
  if (version > 2)
    throw cursor.error("the extended header has version " + std::to_string(version), "0, 1 or 2", offset,
                       "a later version is not known here");
  const bool is_logarithmic = version >= 1 && cursor.readCount("the dynamic range") != 0;
  if (version < 2) return is_logarithmic;
  const std::uint64_t width = cursor.readCount("the width of the heights");
  const std::uint64_t height = cursor.readCount("the height of the heights");
  const auto heights = cursor.take(saturatedProduct({width, height, 2}), "the heights");
  if (!heights.empty())
    info.notes.push_back("its heights (" + std::to_string(width) + " × " + std::to_string(height) +
                         ") are left out");
  return is_logarithmic;
}

}  // namespace

std::unique_ptr<Btf> openDecorrelatedBtf(OpenedBtf opened) {
  BtfCursor& cursor = opened.cursor;
  BtfHeader header;
  readBtfHeader(cursor, opened.signature, header);
  cursor.readCount("the largest number of components");
  const BtfCursor at_model = cursor;
  const auto model = cursor.read<std::int32_t>("the colour model");
  const auto mean = cursor.read<std::array<float, 3>>("the mean colour");
  const auto transform = cursor.read<BtfMatrix>("the colour transformation");
  Matrices matrices;
  matrices.colors = BtfColors(at_model, model, header.channels, transform, mean, false);
  const Sizes sizes = sizesOf(header);
  for (std::uint64_t c = 0; c < sizes.channels; ++c) {
    const std::uint64_t offset = cursor.offset();
    matrices.factors.push_back(readFactors(cursor));
    const bool rows = directionsAreRows(cursor, matrices.factors.back(), sizes, 1, offset);
    if (c > 0 && rows != matrices.directions_are_rows)
      throw cursor.error("the matrix of channel " + std::to_string(c) + " lies the other way round",
                         "as that of channel 0", offset);
    matrices.directions_are_rows = rows;
  }
  return factorized(std::move(opened), std::move(header), std::move(matrices), "DFMF");
}

std::unique_ptr<Btf> openFullMatrixBtf(OpenedBtf opened) {
  BtfCursor& cursor = opened.cursor;
  BtfHeader header;
  readBtfHeader(cursor, opened.signature, header);
  const bool is_logarithmic = opened.signature.is_extended && readExtension(cursor, header.info);
  cursor.readCount("the number of components");
  const std::uint64_t offset = cursor.offset();
  Matrices matrices;
  matrices.colors = BtfColors(cursor, 0, header.channels, {}, {}, is_logarithmic);
  matrices.factors.push_back(readFactors(cursor));
  const Sizes sizes = sizesOf(header);
  matrices.directions_are_rows =
      directionsAreRows(cursor, matrices.factors.back(), sizes, sizes.channels, offset);
  return factorized(std::move(opened), std::move(header), std::move(matrices), "FMF");
}

}  // namespace bakelight::formats
