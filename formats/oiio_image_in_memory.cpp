#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <memory>
#include <string_view>

#include "formats/oiio_image.h"

namespace bakelight::formats::oiio {
namespace {

struct Kind {
  std::string_view start, ending;
};

constexpr Kind kKinds[] = {{"\x89PNG", ".png"}, {"\xFF\xD8\xFF", ".jpg"}, {"GIF8", ".gif"},
                           {"BM", ".bmp"},      {"II*", ".tif"},          {"MM", ".tif"},
                           {"RIFF", ".webp"},   {"DDS ", ".dds"},         {"\x76\x2F\x31\x01", ".exr"},
                           {"#?", ".hdr"}};

// A Targa picture does not begin with any mark. Its header of 18 bytes: the type of image is byte 2, whether
// there is a palette byte 1; width and height begin at byte 12, bits of a texel are byte 16.
bool isTarga(std::span<const std::byte> bytes) {
  constexpr std::size_t kHeader = 18;
  if (bytes.size() <= kHeader) return false;
  const auto at = [&](std::size_t i) { return std::to_integer<int>(bytes[i]); };
  constexpr int kTypes[] = {1, 2, 3, 9, 10, 11}, kBits[] = {8, 15, 16, 24, 32};
  const bool has_palette = at(2) == 1 || at(2) == 9;
  return std::find(std::begin(kTypes), std::end(kTypes), at(2)) != std::end(kTypes) &&
         std::find(std::begin(kBits), std::end(kBits), at(16)) != std::end(kBits) &&
         (has_palette ? at(1) == 1 : at(1) <= 1) && at(12) + at(13) > 0 && at(14) + at(15) > 0;
}

// The ending by which OpenImageIO finds the reader, or "" for what is no picture that we know.
std::string endingOf(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Kind& kind : kKinds) {
    if (text.starts_with(kind.start)) return std::string(kind.ending);
  }
  return isTarga(bytes) ? ".tga" : "";
}

}  // namespace

ImageInMemory openImage(std::span<const std::byte> bytes, const std::string& name, bool converted) {
  const std::string ending = endingOf(bytes);
  if (ending.empty())
    throw badInput({name, "", ""}, "it is no picture of a known kind",
                   "PNG, JPEG, GIF, BMP, TIFF, WebP, DDS, Targa, EXR or Radiance",
                   "export with PNG pictures");
  ImageInMemory opened;
  opened.memory =
      std::make_unique<OIIO::Filesystem::IOMemReader>(const_cast<std::byte*>(bytes.data()), bytes.size());
  OIIO::ImageSpec hints = readingHints(converted);
  OIIO::Filesystem::IOProxy* proxy = opened.memory.get();
  hints.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  opened.input = OIIO::ImageInput::open("picture" + ending, &hints, opened.memory.get());
  if (!opened.input) throw unreadableImage(name, OIIO::geterror());
  return opened;
}

}  // namespace bakelight::formats::oiio
