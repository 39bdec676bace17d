#include "formats/exr_image.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTestFile.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <new>
#include <span>
#include <string_view>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "formats/exr_file.h"
#include "formats/image_checks.h"

namespace bakelight::formats {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c); });
  return text;
}

// OpenImageIO's order of channels: by layer, in that these first, the rest by name as in the file. Depth
// comes last of them: a Z beside an X or Y is none.
std::size_t rankOf(const std::string& name, bool is_position) {
  static constexpr std::array<std::string_view, 18> kFirst = {"r",    "red",  "g",  "green", "b",     "blue",
                                                              "real", "imag", "a",  "alpha", "ar",    "ra",
                                                              "ag",   "ga",   "ab", "ba",    "depth", "z"};
  const auto found = std::find(kFirst.begin(), kFirst.end(), lower(name));
  const auto rank = static_cast<std::size_t>(found - kFirst.begin());
  return is_position && rank + 2 >= kFirst.size() ? kFirst.size() : rank;
}

std::vector<std::string> inOrder(const Imf::ChannelList& channels) {
  std::vector<std::tuple<std::string, std::size_t, std::string>> keys;
  for (auto it = channels.begin(); it != channels.end(); ++it) {
    const std::string name = it.name();
    const std::size_t dot = name.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot + 1);
    const auto has = [&](const char* axis) { return channels.findChannel(layer + axis) != nullptr; };
    const bool is_position = has("X") || has("Y") || has("x") || has("y");
    keys.emplace_back(layer, rankOf(name.substr(layer.size()), is_position), name);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::string> names;
  for (auto& [layer, rank, name] : keys) names.push_back(std::move(name));
  return names;
}

// Of the first part; nothing if there are more, or if it is not plain.
template <class Read>
auto readFirstPart(const std::filesystem::path& path, const Read& read)
    -> decltype(read(std::declval<Imf::MultiPartInputFile&>())) {
  if (!std::filesystem::is_regular_file(path) || !Imf::isOpenExrFile(path.c_str())) return {};
  try {
    Imf::MultiPartInputFile file(path.c_str(), exrThreadsFor(std::filesystem::file_size(path) / 2));
    if (file.parts() != 1 || !isPlainExr(file.header(0))) return {};
    return read(file);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace

std::optional<Image> readPlainExr(const std::filesystem::path& path) {
  return readFirstPart(path, [](Imf::MultiPartInputFile& file) -> std::optional<Image> {
    Imf::InputPart part(file, 0);
    const Imath::Box2i window = part.header().dataWindow();
    Image image(window.max.x - window.min.x + 1, window.max.y - window.min.y + 1,
                inOrder(part.header().channels()));
    const std::size_t channels = image.channelCount(), row = channels * static_cast<std::size_t>(image.width);
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < channels; ++c)
      frame.insert(image.channel_names[c], Imf::Slice::Make(Imf::FLOAT, image.values.data() + c, window,
                                                            channels * sizeof(float), row * sizeof(float)));
    part.setFrameBuffer(frame);
    part.readPixels(window.min.y, window.max.y);
    return image;
  });
}

std::optional<std::map<std::string, std::string>> plainExrMetadata(const std::filesystem::path& path) {
  using Metadata = std::map<std::string, std::string>;
  return readFirstPart(path, [](Imf::MultiPartInputFile& file) -> std::optional<Metadata> {
    Metadata metadata;
    const Imf::Header& header = file.header(0);
    for (auto it = header.begin(); it != header.end(); ++it) {
      const auto* text = dynamic_cast<const Imf::StringAttribute*>(&it.attribute());
      if (text == nullptr || std::string_view(it.name()) == "type" || std::string_view(it.name()) == "name")
        continue;
      if (std::string_view(it.name()).find(':') == std::string_view::npos) return std::nullopt;
      metadata.emplace(it.name(), text->value());
    }
    return metadata;
  });
}

namespace {

// `T` has the size of a value of `type`; `values` are as in Image.
template <class T>
Bytes encode(Imf::PixelType type, const T* values, int width, int height,
             const std::vector<std::string>& names, const std::map<std::string, std::string>& metadata) {
  Imf::Header header(width, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const std::string& name : names) header.channels().insert(name, Imf::Channel(type));
  for (const auto& [key, value] : metadata)
    if (!value.empty()) header.insert(key, Imf::StringAttribute(value));
  const std::size_t texel = names.size() * sizeof(T), row = texel * static_cast<std::size_t>(width);
  auto* first = reinterpret_cast<char*>(const_cast<T*>(values));
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < names.size(); ++c)
    frame.insert(names[c], Imf::Slice(type, first + c * sizeof(T), texel, row));
  Imf::StdOSStream stream;
  {
    Imf::OutputFile file(stream, header, exrThreadsFor(static_cast<std::size_t>(height) * row / sizeof(T)));
    file.setFrameBuffer(frame);
    file.writePixels(height);
  }
  const std::string text = stream.str();
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return Bytes(bytes.begin(), bytes.end());
}

}  // namespace

Bytes encodedExr(const Image& image, ExrPrecision precision,
                 const std::map<std::string, std::string>& metadata) {
  const auto encoded = [&](Imf::PixelType type, const auto* values) {
    return encode(type, values, image.width, image.height, image.channel_names, metadata);
  };
  if (precision == ExrPrecision::kFloat) return encoded(Imf::FLOAT, image.values.data());
  return encoded(Imf::HALF, std::vector<half>(image.values.begin(), image.values.end()).data());
}

Bytes encodedExr(const IndexImage& image, const std::map<std::string, std::string>& metadata) {
  return encode(Imf::UINT, image.values.data(), image.width, image.height, image.channel_names, metadata);
}

}  // namespace bakelight::formats
