#include "formats/gltf_materials.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/gltf_uri.h"
#include "formats/missing_picture.h"

namespace bakelight::formats {
namespace {

GltfLookup lookupAt(const JsonReader& texture_info) {
  GltfLookup lookup;
  lookup.set = texture_info.whole("texCoord", 0);
  const auto moved = extensionOf(texture_info, "KHR_texture_transform");
  if (!moved) return lookup;
  lookup.set = moved->whole("texCoord", lookup.set);
  const auto offset = moved->find("offset"), scale = moved->find("scale"), rotation = moved->find("rotation");
  const auto t = offset ? offset->numbers(2) : std::vector<double>{0, 0};
  const auto s = scale ? scale->numbers(2) : std::vector<double>{1, 1};
  const double angle = rotation ? rotation->number() : 0;
  // Scale, then rotation, counter-clockwise as one sees it with v downwards, then offset.
  const double cosine = std::cos(angle), sine = std::sin(angle);
  lookup.transform = {{{s[0] * cosine, s[1] * sine, t[0]}, {-s[0] * sine, s[1] * cosine, t[1]}}};
  return lookup;
}

AlbedoTexture::Wrap wrapAt(const JsonReader& sampler, const char* key) {
  const auto value = sampler.find(key);
  switch (value ? value->whole() : 10497) {
    case 10497:
      return AlbedoTexture::Wrap::kRepeat;
    case 33648:
      return AlbedoTexture::Wrap::kMirror;
    case 33071:
      return AlbedoTexture::Wrap::kClamp;
    default:
      throw value->error(std::to_string(value->whole()) + " is no way to wrap", "10497, 33071 or 33648");
  }
}

bool isKtx2(const AlbedoTexture& picture, const std::string& media_type) {
  constexpr std::string_view kMagic = "\xABKTX 20";
  const std::string_view start(reinterpret_cast<const char*>(picture.bytes.data()),
                               std::min(picture.bytes.size(), kMagic.size()));
  std::string ending = picture.path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return media_type == "image/ktx2" || ending == ".ktx2" || start == kMagic;
}

bool isSeeThrough(const JsonReader& material) {
  const auto transmission = extensionOf(material, "KHR_materials_transmission");
  const auto factor = transmission ? transmission->find("transmissionFactor") : std::nullopt;
  return material.text("alphaMode", "OPAQUE") != "OPAQUE" || (factor && factor->number() > 0);
}

}  // namespace

GltfMaterials::GltfMaterials(GltfDocument& document)
    : document_(document), read_(document.count("materials")), materials_(read_.size()) {
  for (std::size_t i = 0; i < materials_.size(); ++i) {
    materials_[i].name = document.item("materials", i).text("name", "");
    if (materials_[i].name.empty()) materials_[i].name = "material_" + std::to_string(i);
  }
}

const std::optional<GltfLookup>& GltfMaterials::use(std::size_t index) {
  Material& material = read_[index];
  if (!std::exchange(material.is_read, true)) {
    read(document_.item("materials", index), materials_[index], material.lookup);
  }
  return material.lookup;
}

// Metals have their albedo in the same places; a material of the older model (specular, glossiness) has it in
// others, which go before, as the rest is a fallback then.
void GltfMaterials::read(const JsonReader& material, PartMaterial& result,
                         std::optional<GltfLookup>& lookup) {
  const auto older = extensionOf(material, "KHR_materials_pbrSpecularGlossiness");
  const auto model = older ? older : material.find("pbrMetallicRoughness");
  if (isSeeThrough(material)) see_through_.push_back(result.name);
  if (!model) return;
  if (const auto factor = model->find(older ? "diffuseFactor" : "baseColorFactor")) {
    const auto rgba = factor->numbers(4);
    result.color =
        Float3{static_cast<float>(rgba[0]), static_cast<float>(rgba[1]), static_cast<float>(rgba[2])};
  }
  if (const auto info = model->find(older ? "diffuseTexture" : "baseColorTexture")) {
    result.texture = textureAt(info->at("index"), result);
    if (result.texture >= 0) lookup = lookupAt(*info);
  }
}

int GltfMaterials::textureAt(const JsonReader& reference, const PartMaterial& material) {
  const JsonReader texture = document_.referred(reference, "textures");
  std::size_t index = 0;
  const JsonReader image = imageOf(texture, index);
  std::optional<AlbedoTexture> picture = pictureAt(image, index);
  if (!picture) {
    notes_.push_back(missingPicture(document_.file() + ", " + image.pointer(), image.at("uri").text(),
                                    material.name, material.color));
    return -1;
  }
  if (const auto sampler = texture.find("sampler")) {
    const JsonReader values = document_.referred(*sampler, "samplers");
    picture->wrap_u = wrapAt(values, "wrapS");
    picture->wrap_v = wrapAt(values, "wrapT");
  }
  const auto [place, is_new] = texture_of_image_.try_emplace({index, picture->wrap_u, picture->wrap_v},
                                                             static_cast<int>(textures_.size()));
  if (is_new) textures_.push_back(*std::move(picture));
  return place->second;
}

JsonReader GltfMaterials::imageOf(const JsonReader& texture, std::size_t& image_index) {
  std::optional<JsonReader> source = texture.find("source");
  for (const char* name :
       {"EXT_texture_webp", "MSFT_texture_dds", "EXT_texture_avif", "KHR_texture_basisu"}) {
    const auto extension = extensionOf(texture, name);
    if (!source && extension) source = extension->at("source");
  }
  if (!source) throw texture.error("the texture has no \"source\"", "the index of an image");
  image_index = document_.indexAt(*source, "images");
  return document_.item("images", image_index);
}

std::optional<AlbedoTexture> GltfMaterials::pictureAt(const JsonReader& image, std::size_t index) const {
  AlbedoTexture picture;
  picture.as_stored = true;
  std::string media_type = image.text("mimeType", "");
  const std::string own_name = image.text("name", "");
  picture.name =
      document_.file() + ", image " + std::to_string(index) + (own_name.empty() ? "" : " (" + own_name + ")");
  if (const auto uri = image.find("uri"); uri && isDataUri(uri->text())) {
    DataUri data = readDataUri(uri->text());
    if (!data.fault.empty()) throw uri->error(data.fault, "a data URI as of RFC 2397");
    picture.bytes = std::move(data.bytes);
    if (media_type.empty()) media_type = data.media_type;
  } else if (uri) {
    const auto found = fileOfUri(uri->text(), document_.folder());
    if (!found) return std::nullopt;
    picture.path = *found;
    picture.name = picture.path.string();
  } else {
    const auto bytes = document_.view(image.at("bufferView")).bytes;
    picture.bytes.assign(bytes.begin(), bytes.end());
  }
  if (isKtx2(picture, media_type)) {
    throw image.error("it is a KTX2 picture (Basis Universal), which is not decoded here", "PNG or JPEG",
                      "export with PNG or JPEG pictures");
  }
  return picture;
}

void GltfMaterials::moveTo(MeshParts& parts) {
  if (!see_through_.empty()) {
    std::string names;
    constexpr std::size_t kShown = 5;
    for (std::size_t i = 0; i < std::min(kShown, see_through_.size()); ++i)
      names += (i == 0 ? "" : ", ") + see_through_[i];
    if (see_through_.size() > kShown) names += ", …";
    parts.notes.push_back(std::to_string(see_through_.size()) +
                          (see_through_.size() == 1 ? " material is" : " materials are") +
                          " transparent in the file and baked as opaque: " + names);
  }
  parts.notes.insert(parts.notes.end(), notes_.begin(), notes_.end());
  parts.materials = std::move(materials_);
  parts.textures = std::move(textures_);
}

}  // namespace bakelight::formats
