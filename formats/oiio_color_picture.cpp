#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "formats/oiio_image.h"

namespace bakelight::formats::oiio {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c + ('a' - 'A') : c); });
  return text;
}

// "ViewLayer.Combined.R": the layer is "ViewLayer.Combined", the channel "R".
std::pair<std::string, std::string> layerAndName(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  if (dot == std::string::npos) return {"", channel};
  return {channel.substr(0, dot), channel.substr(dot + 1)};
}

// 0, 1, 2 of red, green and blue; 3 of a grey value; -1 of anything else.
int colorOf(const std::string& name) {
  const std::string plain = lower(name);
  if (plain == "r" || plain == "red") return 0;
  if (plain == "g" || plain == "green") return 1;
  if (plain == "b" || plain == "blue") return 2;
  if (plain == "y" || plain == "l" || plain == "i" || plain == "luminance" || plain == "gray" ||
      plain == "grey")
    return 3;
  return -1;
}

bool isMainLayer(const std::string& layer) {
  const std::string last = lower(layerAndName(layer).second);
  return last == "combined" || last == "beauty" || last == "rgba" || last == "rgb" || last == "color" ||
         last == "colour";
}

using Channels = std::array<int, 3>;

// What is a colour among a part's channels.
struct Candidates {
  std::map<std::string, Channels> layers;  // by name; "" is of no layer
  std::optional<Channels> gray;            // the only one
};

Candidates candidatesOf(const std::vector<std::string>& names) {
  Candidates found;
  std::map<std::string, Channels> layers;
  std::vector<int> gray;
  bool chroma = false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [layer, name] = layerAndName(names[i]);
    const std::string plain = lower(name);
    chroma = chroma || plain == "ry" || plain == "by" || plain == "k";  // Y of CMYK is yellow
    const int color = colorOf(name);
    auto& channels = layers.try_emplace(layer, Channels{-1, -1, -1}).first->second;
    if (color >= 0 && color < 3) channels[static_cast<std::size_t>(color)] = static_cast<int>(i);
    if (color == 3) gray.push_back(static_cast<int>(i));
  }
  for (const auto& [layer, channels] : layers)
    if (*std::min_element(channels.begin(), channels.end()) >= 0) found.layers.emplace(layer, channels);
  if (gray.size() == 1 && !chroma) found.gray = Channels{gray[0], gray[0], gray[0]};
  return found;
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text.append(i == 0 ? "" : ", ").append(names[i]);
  return names.size() > kMost ? text + ", ..." : text;
}

std::optional<Channels> chosen(const Candidates& candidates, const std::string& file) {
  const auto& layers = candidates.layers;
  const auto plain = layers.find("");
  if (plain != layers.end()) return plain->second;
  if (layers.size() == 1) return layers.begin()->second;
  std::vector<std::string> names;
  std::optional<Channels> main;
  int main_count = 0;
  for (const auto& [layer, channels] : layers) {
    names.push_back(layer);
    if (isMainLayer(layer)) main = channels, ++main_count;
  }
  if (main_count == 1) return main;
  if (!layers.empty())
    throw badInput({file, "", ""}, "several of its layers are a colour: " + listed(names),
                   "one colour: channels R, G and B without a layer's name, or in one layer",
                   "save the layer that is meant alone, for example with oiiotool --ch");
  return candidates.gray;
}

// Formats without names for channels: OpenImageIO calls the two of some TIFFs R and G.
bool isGrayWithAlpha(const OIIO::ImageInput& input) {
  return std::string_view(input.format_name()) != "openexr" && input.spec().nchannels == 2;
}

struct Selection {
  int part = 0;
  Channels channels = {};
};

Selection selectColor(OIIO::ImageInput& input, const std::string& file) {
  std::vector<std::string> seen;
  bool deep = false;
  for (int part = 0; input.seek_subimage(part, 0); ++part) {
    const OIIO::ImageSpec& spec = input.spec();
    deep = deep || spec.deep;
    if (spec.deep) continue;
    if (const auto channels = chosen(candidatesOf(spec.channelnames), file)) return {part, *channels};
    if (isGrayWithAlpha(input)) return {part, {0, 0, 0}};
    seen.insert(seen.end(), spec.channelnames.begin(), spec.channelnames.end());
  }
  const std::string reason = input.geterror();
  if (seen.empty() && !deep) throw unreadableImage(file, reason);
  if (seen.empty()) throw badInput({file, "", ""}, "it is deep", "a flat image");
  throw badInput({file, "", ""}, "none of its channels are a colour: " + listed(seen),
                 "channels R, G and B, or a single grey one", "save the picture as RGB");
}

// Reads the channels from the first to the last that is asked for.
Image readChannels(OIIO::ImageInput& input, const Selection& selection, const std::string& file) {
  if (!input.seek_subimage(selection.part, 0)) throw unreadableImage(file, input.geterror());
  const OIIO::ImageSpec spec = input.spec();
  requireFlat(spec, file);
  const auto [low, high] = std::minmax_element(selection.channels.begin(), selection.channels.end());
  const int first = *low, count = *high - first + 1;
  std::vector<float> values(static_cast<std::size_t>(spec.width) * spec.height *
                            static_cast<std::size_t>(count));
  if (!input.read_image(selection.part, 0, first, first + count, OIIO::TypeDesc::FLOAT, values.data()))
    throw unreadableImage(file, input.geterror());
  Image image(spec.width, spec.height, {"R", "G", "B"});
  for (std::size_t texel = 0; 3 * texel < image.values.size(); ++texel)
    for (std::size_t c = 0; c < 3; ++c)
      image.values[3 * texel + c] = values[texel * static_cast<std::size_t>(count) +
                                           static_cast<std::size_t>(selection.channels[c] - first)];
  return image;
}

bool isInteger(const OIIO::TypeDesc& type) {
  return !type.is_floating_point();
}

bool saysLinear(const OIIO::ImageSpec& spec) {
  const std::string space = lower(spec.get_string_attribute("oiio:ColorSpace"));
  return space == "linear" || space == "scene_linear" || space == "lin_srgb";
}

float decoded(float srgb) {  // IEC 61966-2-1
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

ColorPicture readOpened(OIIO::ImageInput& input, const std::string& file, PictureUse use, PictureTurn turn) {
  ColorPicture picture;
  picture.image = readChannels(input, selectColor(input, file), file);
  if (turn == PictureTurn::kAsFileSays) picture.image = upright(std::move(picture.image), input);
  requireFinite(picture.image, file);
  const OIIO::ImageSpec& spec = input.spec();
  picture.decoded = isInteger(spec.format) && !saysLinear(spec);
  if (picture.decoded)
    for (float& value : picture.image.values) value = decoded(value);
  if (use == PictureUse::kReflectance) return picture;
  if (isInteger(spec.format))
    picture.notes.push_back(file + " holds " + std::to_string(8 * spec.format.size()) + "-bit codes" +
                            (picture.decoded ? ", decoded from sRGB" : "") +
                            ": no radiance in it is above 1, so a sun or lamp in it is too dim; an HDR "
                            "picture (OpenEXR, Radiance) has the whole range");
  if (const std::string note = noteIfBlack(picture.image, file); !note.empty()) picture.notes.push_back(note);
  return picture;
}

}  // namespace

ColorPicture readColorPicture(const std::filesystem::path& path, PictureUse use, PictureTurn turn) {
  const std::string file = path.string();
  return readOpened(*openImage(file, true), file, use, turn);
}

ColorPicture readColorPicture(std::span<const std::byte> bytes, const std::string& name, PictureUse use,
                              PictureTurn turn) {
  const ImageInMemory opened = openImage(bytes, name, true);
  return readOpened(*opened.input, name, use, turn);
}

}  // namespace bakelight::formats::oiio
