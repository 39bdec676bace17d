#include "formats/btf_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string_view>

namespace bakelight::formats {
namespace {

// Longer ones before those that begin alike.
constexpr BtfSignature kSignatures[] = {
    {"!DFMF08FCR", BtfLayout::kDecorrelated, true, false}, {"!FMF12FCER", BtfLayout::kFullMatrix, true, true},
    {"!BDIF06R2!", BtfLayout::kRaw, true, false},          {"!FMF06FCR", BtfLayout::kFullMatrix, true, false},
    {"!PVF06FCR", BtfLayout::kPerView, true, false},       {"!FMF06FC", BtfLayout::kFullMatrix, false, false},
    {"!PVF06FC", BtfLayout::kPerView, false, false}};
constexpr std::uint32_t kNewestMeta = 4;
constexpr int kMostTexels = 65536;  // a side
constexpr std::uint64_t kSetupLength = 80;
constexpr std::uint64_t kMostChannels = 1024;

BtfDirection directionOf(const BtfCursor& cursor, const std::byte* bytes, std::uint64_t offset,
                         const std::string& what) {
  std::array<float, 2> angles;
  std::memcpy(angles.data(), bytes, sizeof(angles));
  constexpr double kRounding_rad = 1e-3;
  const double polar = angles[0];
  if (!(polar >= -kRounding_rad && polar <= std::numbers::pi / 2 + kRounding_rad) ||
      !std::isfinite(angles[1]))
    throw cursor.error(
        what + " is at the angles " + std::to_string(angles[0]) + " and " + std::to_string(angles[1]),
        "a polar angle from 0 to π/2, in radians, and an azimuth", offset);
  return {std::clamp(polar, 0.0, std::numbers::pi / 2), angles[1]};
}

}  // namespace

const BtfSignature* btfSignatureOf(std::span<const std::byte> bytes) {
  for (const BtfSignature& signature : kSignatures) {
    const std::string_view text(signature.text);
    if (bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0)
      return &signature;
  }
  return nullptr;
}

void readBtfMeta(BtfCursor& cursor, BtfHeader& header) {
  BtfInfo& info = header.info;
  const std::uint64_t begin = cursor.offset();
  const std::uint32_t size = cursor.readCount("the size of the meta data");
  const std::uint64_t version_offset = cursor.offset();
  const std::uint32_t version = cursor.readCount("the version of the meta data");
  if (version < 1 || version > kNewestMeta)
    throw cursor.error("the meta data have version " + std::to_string(version), "1 to 4", version_offset,
                       "a later version is not known here");
  info.measurement_setup = cursor.readText(kSetupLength, "the meta data");
  info.image_sensor = cursor.readText(kSetupLength, "the meta data");
  info.light_source = cursor.readText(kSetupLength, "the meta data");
  info.texels_per_mm = cursor.read<float>("the meta data");
  if (!std::isfinite(info.texels_per_mm) || info.texels_per_mm < 0) info.texels_per_mm = 0;
  info.rgb_scale = cursor.read<std::array<float, 3>>("the meta data");
  info.cosine_inside = version > 1 && cursor.readCount("the cosine flag") != 0;
  if (version > 2) cursor.take(cursor.readCount("the size of the XML"), "the XML");
  header.channels = {"R", "G", "B"};
  if (version > 3) {
    const std::uint64_t offset = cursor.offset();
    const std::uint32_t count = cursor.readCount("the number of channels");
    if (count < 1 || count > kMostChannels)
      throw cursor.error("there are " + std::to_string(count) + " channels",
                         "1 to " + std::to_string(kMostChannels), offset);
    header.channels.clear();
    for (std::uint32_t c = 0; c < count; ++c)
      header.channels.push_back(
          cursor.readText(cursor.readCount("the size of a channel's name"), "a channel's name"));
  }
  if (cursor.offset() - begin != size)
    throw cursor.error("the meta data say that they have " + std::to_string(size) + " bytes",
                       std::to_string(cursor.offset() - begin) + ", which their parts have", begin);
}

void readBtfSampling(BtfCursor& cursor, BtfInfo& info) {
  const std::uint64_t begin = cursor.offset();
  const std::uint32_t views = cursor.readCount("the number of views");
  if (views == 0) throw cursor.error("there are no views", "one or more", begin);
  constexpr std::uint64_t kAngles = 2 * sizeof(float);
  std::span<const std::byte> first;
  bool differ = false;
  for (std::uint32_t v = 0; v < views; ++v) {
    const std::uint64_t offset = cursor.offset();
    info.views.push_back(
        directionOf(cursor, cursor.take(kAngles, "the views").data(), offset, "view " + std::to_string(v)));
    const std::uint64_t count_offset = cursor.offset();
    const std::uint32_t lights = cursor.readCount("the number of lights");
    if (lights == 0 || (v > 0 && lights * kAngles != first.size()))
      throw cursor.error("view " + std::to_string(v) + " has " + std::to_string(lights) + " lights",
                         v > 0 ? std::to_string(first.size() / kAngles) + ", as view 0" : "one or more",
                         count_offset);
    const std::uint64_t list_offset = cursor.offset();
    const auto list = cursor.take(lights * kAngles, "the lights of view " + std::to_string(v));
    if (v > 0) {
      differ = differ || std::memcmp(list.data(), first.data(), list.size()) != 0;
      continue;
    }
    first = list;
    for (std::uint32_t l = 0; l < lights; ++l)
      info.lights.push_back(directionOf(cursor, list.data() + l * kAngles, list_offset + l * kAngles,
                                        "light " + std::to_string(l)));
  }
  if (differ)
    info.notes.push_back("the lists of lights differ from view to view: that of view 0 is taken for all");
}

void readBtfSize(BtfCursor& cursor, BtfInfo& info) {
  const std::uint64_t offset = cursor.offset();
  const std::uint32_t width = cursor.readCount("the width"), height = cursor.readCount("the height");
  if (width < 1 || height < 1 || width > kMostTexels || height > kMostTexels)
    throw cursor.error("pictures are " + std::to_string(width) + " × " + std::to_string(height) + " texels",
                       "1 to " + std::to_string(kMostTexels) + " a side", offset);
  info.width = static_cast<int>(width), info.height = static_cast<int>(height);
}

void readBtfRotations(BtfCursor& cursor, BtfInfo& info) {
  const std::uint32_t count = cursor.readCount("the number of rotations");
  const std::uint64_t offset = cursor.offset();
  using Rotation = std::array<float, 9>;
  const auto bytes = cursor.take(saturatedProduct({count, sizeof(Rotation)}), "the rotations");
  if (count > 1 && count != static_cast<std::uint64_t>(info.width) * info.height)
    throw cursor.error(
        "there are " + std::to_string(count) + " rotations",
        "none, one, or one a texel: " + std::to_string(info.width) + " × " + std::to_string(info.height),
        offset - sizeof(count));
  std::uint32_t turned = 0;
  constexpr Rotation kIdentity = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::uint32_t r = 0; r < count; ++r) {
    Rotation rotation;
    std::memcpy(rotation.data(), bytes.data() + r * sizeof(Rotation), sizeof(Rotation));
    double difference = 0;
    for (std::size_t i = 0; i < rotation.size(); ++i)
      difference += std::abs(static_cast<double>(rotation[i]) - kIdentity[i]);
    if (!std::isfinite(difference))
      throw cursor.error("rotation " + std::to_string(r) + " is not finite", "9 numbers",
                         offset + r * sizeof(Rotation));
    if (difference > 1e-5) ++turned;
  }
  if (turned > 0)
    info.notes.push_back(
        std::to_string(turned) + " of " + std::to_string(count) +
        " rotations turn the frame of a texel: values are taken as they stand, directions as if no "
        "frame were turned");
}

void readBtfHeader(BtfCursor& cursor, const BtfSignature& signature, BtfHeader& header) {
  readBtfMeta(cursor, header);
  readBtfSampling(cursor, header.info);
  readBtfSize(cursor, header.info);
  if (signature.has_rotations) readBtfRotations(cursor, header.info);
}

}  // namespace bakelight::formats
