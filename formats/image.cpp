#include "formats/image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <set>
#include <span>
#include <stdexcept>

#include "formats/error.h"
#include "formats/file.h"

namespace bakelight::formats {
namespace {

constexpr float kLargestHalf = 65504.0F;

std::string elementName(const Image& image, std::size_t value_index) {
  const std::size_t texel = value_index / image.channelCount();
  const auto width = static_cast<std::size_t>(image.width);
  return "texel (" + std::to_string(texel % width) + ", " + std::to_string(texel / width) + "), channel " +
         image.channel_names[value_index % image.channelCount()];
}

void checkFinite(const Image& image, const std::string& file) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (std::isfinite(image.values[i])) continue;
    throw badInput({file, elementName(image, i), ""},
                   std::isnan(image.values[i]) ? "it is NaN" : "it is infinite", "finite values",
                   "repair the image, for example with oiiotool --fixnan box3");
  }
}

void checkFitsHalf(const Image& image, const std::string& file) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (std::abs(image.values[i]) <= kLargestHalf) continue;
    throw badInput({file, elementName(image, i), ""},
                   "the value " + std::to_string(image.values[i]) + " does not fit half precision",
                   "at most 65504 in magnitude", "scale the image down, or write it with 32-bit floats");
  }
}

// What only a bug can get wrong.
void checkShape(const Image& image) {
  const std::set<std::string> names(image.channel_names.begin(), image.channel_names.end());
  if (image.width < 1 || image.height < 1 || names.empty() || names.size() != image.channelCount()) {
    throw std::logic_error("an image has at least one texel, and channels of different names");
  }
  if (image.values.size() != static_cast<std::size_t>(image.width) * image.height * image.channelCount()) {
    throw std::logic_error("an image has one value for each texel and channel");
  }
}

OIIO::ImageSpec specOf(const Image& image, const OIIO::TypeDesc& type) {
  OIIO::ImageSpec spec(image.width, image.height, static_cast<int>(image.channelCount()), type);
  spec.channelnames = image.channel_names;
  return spec;
}

// In memory, as a library that writes to disk itself would leave half a file behind on a full disk. `path` is
// for messages.
template <class Value>
std::vector<unsigned char> encoded(const std::filesystem::path& path, const char* format,
                                   const OIIO::ImageSpec& spec, const OIIO::TypeDesc& value_type,
                                   const std::vector<Value>& values) {
  std::vector<unsigned char> buffer;
  OIIO::Filesystem::IOVecOutput memory(buffer);
  const auto output = OIIO::ImageOutput::create(format);
  if (!output) {
    throw Error(ExitStatus::kNotAvailable, {path.string(), "", ""},
                std::string("this OpenImageIO cannot write ") + format, "", "install its plug-in");
  }
  output->set_ioproxy(&memory);
  if (!output->open(path.filename().string(), spec) || !output->write_image(value_type, values.data()) ||
      !output->close()) {
    throw cannotWrite(path.string(), output->geterror());
  }
  return buffer;
}

std::vector<unsigned char> encodedPng(const std::filesystem::path& path, const Image& image) {
  checkShape(image);
  if (image.channelCount() > 4) throw std::logic_error("a PNG has 1 to 4 channels");
  checkFinite(image, path.string());
  OIIO::ImageSpec spec = specOf(image, OIIO::TypeDesc::UINT8);
  spec["oiio:ColorSpace"] = "sRGB";
  spec["oiio:UnassociatedAlpha"] = 1;
  std::vector<std::uint8_t> codes(image.values.size());
  std::transform(image.values.begin(), image.values.end(), codes.begin(), [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * 255.0F));
  });
  return encoded(path, "png", spec, OIIO::TypeDesc::UINT8, codes);
}

Error unreadable(const std::string& file, const std::string& reason) {
  return badInput({file, "", ""}, "the image cannot be read (" + reason + ")", "a whole image file",
                  "copy or make it again");
}

Image readWith(OIIO::ImageInput& input, const std::string& file, NonFinite non_finite) {
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.depth > 1 || spec.deep) throw badInput({file, "", ""}, "it is deep or a volume", "a flat image");
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height) {
    throw badInput(
        {file, "", ""}, "its data window is not its display window", "an image that fills its frame",
        "fill the frame with oiiotool --croptofull, or drop it with oiiotool --origin +0+0 --fullpixels");
  }
  Image image(spec.width, spec.height, spec.channelnames);
  if (!input.read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, image.values.data())) {
    throw unreadable(file, input.geterror());
  }
  if (non_finite == NonFinite::kReject) checkFinite(image, file);
  return image;
}

OIIO::ImageSpec readingHints() {
  OIIO::ImageSpec hints;
  hints["oiio:UnassociatedAlpha"] = 1;  // values as they stand in the file: colour is not multiplied by alpha
  hints["oiio:RawColor"] = 1;           // nor converted
  return hints;
}

// The ending by which OpenImageIO finds the reader, or "" for what is no picture that we know.
std::string endingOf(std::span<const std::byte> bytes) {
  struct Kind {
    std::string_view start, ending;
  };
  static constexpr Kind kKinds[] = {
      {"\x89PNG", ".png"}, {"\xFF\xD8\xFF", ".jpg"}, {"GIF8", ".gif"},  {"BM", ".bmp"},
      {"II*", ".tif"},     {"MM", ".tif"},           {"RIFF", ".webp"}, {"\x76\x2F\x31\x01", ".exr"},
      {"#?", ".hdr"}};
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Kind& kind : kKinds) {
    if (text.starts_with(kind.start)) return std::string(kind.ending);
  }
  return "";
}

std::unique_ptr<OIIO::ImageInput> opened(const std::string& file) {
  if (!std::filesystem::is_regular_file(file))
    throw badInput({file, "", ""}, "there is no such file", "an image");
  const OIIO::ImageSpec hints = readingHints();
  auto input = OIIO::ImageInput::open(file, &hints);
  if (!input) throw unreadable(file, OIIO::geterror());
  return input;
}

}  // namespace

int Image::channelIndex(const std::string& name) const {
  const auto found = std::find(channel_names.begin(), channel_names.end(), name);
  return found == channel_names.end() ? -1 : static_cast<int>(found - channel_names.begin());
}

Image readImage(const std::filesystem::path& path, NonFinite non_finite) {
  const std::string file = path.string();
  try {
    return readWith(*opened(file), file, non_finite);
  } catch (const std::bad_alloc&) {
    throw badInput({file, "", ""}, "the image does not fit into memory", "a smaller image");
  }
}

Image readImage(std::span<const std::byte> bytes, const std::string& name, NonFinite non_finite) {
  const std::string ending = endingOf(bytes);
  if (ending.empty())
    throw badInput({name, "", ""}, "it is no picture of a known kind",
                   "PNG, JPEG, GIF, BMP, TIFF, WebP, EXR or Radiance");
  OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
  OIIO::Filesystem::IOProxy* proxy = &memory;
  OIIO::ImageSpec hints = readingHints();
  hints.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  const auto input = OIIO::ImageInput::open("picture" + ending, &hints, &memory);
  if (!input) throw unreadable(name, OIIO::geterror());
  try {
    return readWith(*input, name, non_finite);
  } catch (const std::bad_alloc&) {
    throw badInput({name, "", ""}, "the image does not fit into memory", "a smaller image");
  }
}

std::map<std::string, std::string> readImageMetadata(const std::filesystem::path& path) {
  const auto input = opened(path.string());
  std::map<std::string, std::string> metadata;
  for (const OIIO::ParamValue& attribute : input->spec().extra_attribs)
    if (attribute.type() == OIIO::TypeString)
      metadata.emplace(attribute.name().string(), attribute.get_string());
  return metadata;
}

void writeExr(const std::filesystem::path& path, const Image& image, ExrPrecision precision,
              const std::map<std::string, std::string>& metadata) {
  checkShape(image);
  checkFinite(image, path.string());
  if (precision == ExrPrecision::kHalf) checkFitsHalf(image, path.string());
  const OIIO::TypeDesc type = precision == ExrPrecision::kHalf ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT;
  OIIO::ImageSpec spec = specOf(image, type);
  spec["compression"] = "zip";
  // OpenImageIO adds the date of today unless there is one already; a number it does not write at all.
  OIIO::attribute("debug", 0);  // would tell on standard output that DateTime is no text
  spec["DateTime"] = 0;
  for (const auto& [key, value] : metadata) spec.attribute(key, value);
  writeFileAtomically(path, std::as_bytes(std::span<const unsigned char>(
                                encoded(path, "exr", spec, OIIO::TypeDesc::FLOAT, image.values))));
}

void writePng(const std::filesystem::path& path, const Image& image) {
  writeFileAtomically(path, std::as_bytes(std::span<const unsigned char>(encodedPng(path, image))));
}

std::string pngDataUri(const Image& image) {
  const std::vector<unsigned char> png = encodedPng("picture.png", image);
  return "data:image/png;base64," +
         OIIO::Strutil::base64_encode({reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace bakelight::formats
