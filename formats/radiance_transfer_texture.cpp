#include "formats/radiance_transfer_texture.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "formats/error.h"
#include "formats/index_image.h"
#include "formats/json_reader.h"
#include "formats/pack_contents.h"

namespace bakelight::formats {
namespace {

constexpr const char* kLayoutKey = "bakelight:radiance_transfer_textures";
constexpr const char* kHeight = "height";
constexpr int kMostViews = 64, kMostTexels = 8192;

std::vector<std::string> channelNames(int order) {
  std::vector<std::string> names;
  for (int i = 0; i < order * order; ++i) {
    const std::string layer = "sh" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".";
    for (const char* color : {"R", "G", "B"}) names.push_back(layer + color);
  }
  return names;
}

// Where a texture lies in the image.
struct Block {
  int top = 0;  // px
  int width = 0, height = 0;
};

Block blockBelow(const Block& above, const RadianceTransferTexture& texture) {
  return {above.top + above.height, texture.views * texture.width, texture.views * texture.height};
}

// Calls visit(index of the response, texel of the image) for all of a texture's.
template <class Texture, class Picture, class Visit>
void visitTexels(Texture& texture, Picture& image, int top, const Visit& visit) {
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column)
      for (int y = 0; y < texture.height; ++y)
        for (int x = 0; x < texture.width; ++x)
          visit(
              texture.responseIndex(column, row, x, y),
              image.texel(column * texture.width + x, top + (texture.views - 1 - row) * texture.height + y));
}

void check(std::span<const RadianceTransferTexture> textures) {
  std::set<std::string> materials;
  for (const RadianceTransferTexture& texture : textures) {
    if (texture.order != textures.front().order || texture.order < 1)
      throw std::logic_error("radiance transfer textures of different orders");
    if (texture.values.size() != texture.responseCount() * texture.responseSize() ||
        (!texture.heights.empty() && texture.heights.size() != texture.responseCount()))
      throw std::logic_error("a radiance transfer texture has another number of values than it says");
    if (!materials.insert(texture.material).second)
      throw std::logic_error("two radiance transfer textures of one material");
  }
  if (textures.empty()) throw std::logic_error("no radiance transfer texture");
}

}  // namespace

void writeRadianceTransferTextures(const std::filesystem::path& path,
                                   std::span<const RadianceTransferTexture> textures,
                                   ExrPrecision precision) {
  check(textures);
  const int order = textures.front().order;
  Json layout = {{"order", order}, {"textures", Json::array()}};
  Block block;
  int width = 0;
  bool any_heights = false;
  for (const RadianceTransferTexture& texture : textures) {
    block = blockBelow(block, texture);
    width = std::max(width, block.width);
    any_heights = any_heights || !texture.heights.empty();
    layout["textures"].push_back({{"material", texture.material},
                                  {"views", texture.views},
                                  {"width", texture.width},
                                  {"height", texture.height},
                                  {"heights", !texture.heights.empty()}});
  }
  std::vector<std::string> names = channelNames(order);
  const std::size_t coefficients = textures.front().coefficientCount(), height_channel = names.size();
  if (any_heights) names.emplace_back(kHeight);
  Image image(width, block.top + block.height, names);
  block = {};
  for (const RadianceTransferTexture& texture : textures) {
    block = blockBelow(block, texture);
    visitTexels(texture, image, block.top, [&](std::size_t index, float* texel) {
      const float* response = &texture.values[index * texture.responseSize()];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < coefficients; ++i) texel[3 * i + c] = response[c * coefficients + i];
      if (!texture.heights.empty()) texel[height_channel] = texture.heights[index];
    });
  }
  writeExr(path, image, precision, {{kLayoutKey, layout.dump()}});
}

std::vector<RadianceTransferTexture> readRadianceTransferTextures(const std::filesystem::path& path) {
  const std::string file = path.string();
  const std::map<std::string, std::string> metadata = readImageMetadata(path);
  const auto found = metadata.find(kLayoutKey);
  if (found == metadata.end())
    throw badInput({file, std::string("attribute ") + kLayoutKey, ""}, "it has no such attribute",
                   "radiance transfer textures", "make it with rtt");
  const std::string remedy = "make it again with rtt";
  const Json layout = Json::parse(found->second, nullptr, false);
  const JsonReader reader(layout, file, std::string("/") + kLayoutKey, remedy);
  const int order = reader.at("order").integer(1, kMaxOrder);
  std::vector<RadianceTransferTexture> textures;
  Block block;
  int width = 0;
  for (const JsonReader& entry : reader.at("textures").items()) {
    RadianceTransferTexture texture{.material = entry.text("material"),
                                    .order = order,
                                    .views = entry.at("views").integer(1, kMostViews),
                                    .width = entry.at("width").integer(1, kMostTexels),
                                    .height = entry.at("height").integer(1, kMostTexels)};
    if (entry.has("heights") && entry.at("heights").boolean())
      texture.heights.resize(texture.responseCount());
    block = blockBelow(block, texture);
    width = std::max(width, block.width);
    textures.push_back(std::move(texture));
  }
  if (textures.empty()) throw reader.error("it names no texture", "one or more");

  const Image image = readImage(path);
  const std::vector<std::string> names = channelNames(order);
  const auto channel = [&](const std::string& name) {
    const int at = image.channelIndex(name);
    if (at < 0) throw badInput({file, "channel " + name, ""}, "it has no such channel", "", remedy);
    return static_cast<std::size_t>(at);
  };
  std::vector<std::size_t> channels;  // in the image
  for (const std::string& name : names) channels.push_back(channel(name));
  const int height = block.top + block.height;
  if (image.width != width || image.height != height)
    throw badInput({file, "", ""},
                   "it has " + std::to_string(image.width) + " × " + std::to_string(image.height) + " pixels",
                   std::to_string(width) + " × " + std::to_string(height) + " for the textures that it names",
                   remedy);
  block = {};
  for (RadianceTransferTexture& texture : textures) {
    texture.allocate();
    block = blockBelow(block, texture);
    const std::size_t coefficients = texture.coefficientCount();
    const std::size_t height_channel = texture.heights.empty() ? 0 : channel(kHeight);
    visitTexels(texture, image, block.top, [&](std::size_t index, const float* texel) {
      float* response = &texture.values[index * texture.responseSize()];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < coefficients; ++i)
          response[c * coefficients + i] = texel[channels[3 * i + c]];
      if (!texture.heights.empty()) texture.heights[index] = texel[height_channel];
    });
  }
  return textures;
}

bool isRadianceTransferTexture(const std::filesystem::path& path) {
  const std::vector<std::string> channels = exrChannels(path);
  return std::find(channels.begin(), channels.end(), "sh00.R") != channels.end() &&
         readImageMetadata(path).contains(kLayoutKey);
}

}  // namespace bakelight::formats
