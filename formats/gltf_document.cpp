#include "formats/gltf_document.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/gltf_uri.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

constexpr const char* kCutRemedy = "copy or export the file again, it was probably cut short";
constexpr const char* kExportAgain = "export the file again";

std::uint32_t uint32At(std::span<const std::byte> bytes, std::size_t offset) {
  static_assert(std::endian::native == std::endian::little);
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

std::string_view textOf(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Extensions that are read, and those that change nothing that is read here. The ones with another way of
// storing pictures are let pass, as only the albedo's picture is of interest.
constexpr const char* kKnownExtensions[] = {"KHR_mesh_quantization",
                                            "KHR_draco_mesh_compression",
                                            "EXT_meshopt_compression",
                                            "KHR_texture_transform",
                                            "EXT_mesh_gpu_instancing",
                                            "KHR_node_visibility",
                                            "KHR_texture_basisu",
                                            "EXT_texture_webp",
                                            "EXT_texture_avif",
                                            "MSFT_texture_dds",
                                            "KHR_materials_pbrSpecularGlossiness",
                                            "KHR_materials_unlit",
                                            "KHR_materials_anisotropy",
                                            "KHR_materials_clearcoat",
                                            "KHR_materials_diffuse_transmission",
                                            "KHR_materials_dispersion",
                                            "KHR_materials_emissive_strength",
                                            "KHR_materials_ior",
                                            "KHR_materials_iridescence",
                                            "KHR_materials_sheen",
                                            "KHR_materials_specular",
                                            "KHR_materials_transmission",
                                            "KHR_materials_variants",
                                            "KHR_materials_volume",
                                            "KHR_lights_punctual",
                                            "EXT_lights_image_based",
                                            "KHR_animation_pointer",
                                            "KHR_xmp",
                                            "KHR_xmp_json_ld",
                                            "EXT_mesh_features",
                                            "EXT_structural_metadata",
                                            "EXT_instance_features"};

bool isKnownExtension(const std::string& name) {
  return std::find(std::begin(kKnownExtensions), std::end(kKnownExtensions), name) !=
         std::end(kKnownExtensions);
}

}  // namespace

GltfDocument::GltfDocument(const fs::path& path, std::span<const std::byte> bytes,
                           std::vector<std::string>& notes)
    : file_(path.string()), folder_(path.parent_path()) {
  if (textOf(bytes).starts_with("glTF")) {
    openBinary(bytes, notes);
  } else {
    openText(textOf(bytes));
  }
  if (!json_->is_object()) throw root().error("it is no glTF file: its JSON is no object", "glTF 2.0");
  checkVersion();
  checkExtensions();
  buffers_.resize(count("buffers"));
  unpacked_views_.resize(count("bufferViews"));
}

GltfDocument::~GltfDocument() = default;

void GltfDocument::openText(std::string_view text) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw badInput({file_, "", ""}, "the file is empty", "glTF 2.0, text or binary", "export it again");
  }
  json_ = std::make_unique<Json>(parseJson(text, file_));
}

// glTF 2.0, 4.4: a header of 12 bytes; chunks of length, type and content; JSON, then perhaps BIN, then
// perhaps others.
void GltfDocument::openBinary(std::span<const std::byte> bytes, std::vector<std::string>& notes) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
  const auto error = [&](const std::string& element, const std::string& what, const std::string& expected,
                         const std::string& remedy) {
    return badInput({file_, element, ""}, what, expected, remedy);
  };
  if (bytes.size() < kHeader + kChunkHeader) throw error("header", "the file ends inside it", "", kCutRemedy);
  if (const std::uint32_t version = uint32At(bytes, 4); version != 2) {
    throw error("header", "it is binary glTF of version " + std::to_string(version), "version 2",
                "convert it to glTF 2.0");
  }
  const std::uint32_t length = uint32At(bytes, 8);
  if (length > bytes.size()) {
    throw error(
        "header",
        "the file has " + std::to_string(bytes.size()) + " bytes, its header says " + std::to_string(length),
        "as many bytes as the header says", kCutRemedy);
  }
  if (length < bytes.size()) {
    notes.push_back(std::to_string(bytes.size() - length) +
                    " bytes after the end of the binary glTF were left out");
  }
  bytes = bytes.first(length);
  std::size_t offset = kHeader;
  for (int chunk = 0; offset + kChunkHeader <= bytes.size(); ++chunk) {
    const std::uint32_t size = uint32At(bytes, offset), type = uint32At(bytes, offset + 4);
    offset += kChunkHeader;
    const std::string element = "chunk " + std::to_string(chunk);
    if (size > bytes.size() - offset) {
      throw error(element, "its " + std::to_string(size) + " bytes end beyond the file",
                  "chunks within the length of the header", kExportAgain);
    }
    const auto content = bytes.subspan(offset, size);
    if (chunk == 0) {
      if (type != kJsonChunk) throw error(element, "it is no JSON", "a JSON chunk first", kExportAgain);
      std::string_view text = textOf(content);
      while (text.ends_with('\0')) text.remove_suffix(1);  // padding of careless writers
      json_ = std::make_unique<Json>(parseJson(text, file_));
    } else if (chunk == 1 && type == kBinaryChunk) {
      binary_ = content;
    }
    offset += size;
  }
  if (json_ == nullptr) throw error("header", "it has no chunk", "a JSON chunk", kCutRemedy);
}

void GltfDocument::checkVersion() const {
  const auto asset = root().find("asset");
  const auto sections_of_1 =
      root().find("techniques") || (json_->contains("meshes") && (*json_)["meshes"].is_object());
  if (!asset) {
    throw root().error(sections_of_1 ? "it is glTF 1.0" : "it is no glTF file: it has no \"asset\"",
                       "glTF 2.0", sections_of_1 ? "convert it to glTF 2.0" : "");
  }
  const auto version = asset->find("version");
  if (!version) {
    throw asset->error(sections_of_1 ? "it is glTF 1.0" : "it has no \"version\"", "\"version\": \"2.0\"",
                       "convert it to glTF 2.0");
  }
  if (version->text() != "2" && !version->text().starts_with("2.")) {
    throw version->error("it is glTF " + version->text(), "2.0", "convert it to glTF 2.0");
  }
  if (const auto least = asset->find("minVersion"); least && least->text() != "2.0" && least->text() != "2") {
    throw least->error("it asks for a reader of glTF " + least->text(), "2.0", "convert it to glTF 2.0");
  }
}

void GltfDocument::checkExtensions() const {
  const auto required = root().find("extensionsRequired");
  for (std::size_t i = 0; required && i < required->size(); ++i) {
    const JsonReader name = required->at(i);
    if (isKnownExtension(name.text())) continue;
    throw name.error("the file requires the extension " + name.text() + ", which is not read here", "",
                     "export it without this extension");
  }
}

JsonReader GltfDocument::root() const {
  return {*json_, file_, "", kExportAgain};
}

std::size_t GltfDocument::count(const char* section) const {
  const auto list = root().find(section);
  return list ? list->size() : 0;
}

JsonReader GltfDocument::item(const char* section, std::size_t index) const {
  return root().at(section).at(index);
}

std::size_t GltfDocument::indexAt(const JsonReader& reference, const char* section) const {
  const std::uint64_t index = reference.whole();
  const std::size_t there = count(section);
  if (index < there) return static_cast<std::size_t>(index);
  throw reference.error(
      std::to_string(index) + " of \"" + section + "\" does not exist",
      there == 0 ? "a list \"" + std::string(section) + "\"" : "0 to " + std::to_string(there - 1));
}

JsonReader GltfDocument::referred(const JsonReader& reference, const char* section) const {
  return item(section, indexAt(reference, section));
}

std::optional<fs::path> fileOfUri(const std::string& uri, const fs::path& folder) {
  for (const fs::path& path : pathsOfUri(uri)) {
    std::error_code ignored;
    if (fs::is_regular_file(folder / path, ignored)) return folder / path;
  }
  return std::nullopt;
}

fs::path existingFile(const JsonReader& uri, const fs::path& folder) {
  const auto paths = pathsOfUri(uri.text());
  if (paths.empty()) {
    throw uri.error("'" + uri.text() + "' is not the name of a file", "a path, relative to the glTF file",
                    "put the file beside it and name it here");
  }
  if (auto found = fileOfUri(uri.text(), folder)) return *std::move(found);
  throw uri.error("the file " + (folder / paths[0]).string() + " is missing",
                  "a file that the glTF file names", "put it there, or export as one .glb file");
}

std::optional<JsonReader> extensionOf(const JsonReader& object, std::string_view name) {
  const auto extensions = object.find("extensions");
  return extensions ? extensions->find(name) : std::nullopt;
}

Bytes GltfDocument::bytesOfUri(const JsonReader& uri) const {
  if (!isDataUri(uri.text())) return readFile(existingFile(uri, folder_));
  DataUri data = readDataUri(uri.text());
  if (!data.fault.empty()) throw uri.error(data.fault, "a data URI as of RFC 2397");
  return std::move(data.bytes);
}

void GltfDocument::loadBuffer(std::size_t index) {
  const JsonReader buffer = item("buffers", index);
  Buffer loaded;
  if (const auto uri = buffer.find("uri")) {
    loaded.own = bytesOfUri(*uri);
    loaded.bytes = loaded.own;
  } else if (index == 0 && binary_) {
    loaded.bytes = *binary_;
  } else {
    throw buffer.error("it has no \"uri\"" + std::string(index == 0 ? ", and the file has no BIN chunk" : ""),
                       "a \"uri\", or bytes in a binary glTF file");
  }
  const JsonReader length = buffer.at("byteLength");
  if (length.whole() > loaded.bytes.size()) {
    throw length.error("the buffer has " + std::to_string(loaded.bytes.size()) + " bytes, not " +
                           std::to_string(length.whole()),
                       "as many bytes as this says", kCutRemedy);
  }
  loaded.bytes = loaded.bytes.first(static_cast<std::size_t>(length.whole()));
  buffers_[index] = std::move(loaded);
}

std::span<const std::byte> GltfDocument::bufferBytes(const JsonReader& reference, std::uint64_t offset,
                                                     std::uint64_t length, const JsonReader& place) {
  const std::size_t index = indexAt(reference, "buffers");
  if (!buffers_[index]) loadBuffer(index);
  const auto bytes = buffers_[index]->bytes;
  if (offset > bytes.size() || length > bytes.size() - offset) {
    throw place.error(
        std::to_string(length) + " bytes from " + std::to_string(offset) + " on end beyond the buffer",
        "at most its " + std::to_string(bytes.size()) + " bytes");
  }
  return bytes.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
}

GltfView GltfDocument::view(const JsonReader& reference) {
  const std::size_t index = indexAt(reference, "bufferViews");
  const JsonReader view = item("bufferViews", index);
  GltfView result;
  if (const auto stride = view.find("byteStride")) {
    result.stride = static_cast<std::size_t>(stride->whole());
    if (result.stride < 1 || result.stride > 252) {
      throw stride->error(std::to_string(result.stride) + " is out of range", "4 to 252");
    }
  }
  if (!unpacked_views_[index]) unpacked_views_[index] = meshoptDecoded(view, *this);
  if (unpacked_views_[index]) {
    result.bytes = *unpacked_views_[index];
    return result;
  }
  const JsonReader length = view.at("byteLength");
  result.bytes = bufferBytes(view.at("buffer"), view.whole("byteOffset", 0), length.whole(), length);
  return result;
}

std::uint64_t GltfDocument::loadedBytes() const {
  std::uint64_t sum = 0;
  for (const auto& buffer : buffers_) sum += buffer ? buffer->bytes.size() : 0;
  for (const auto& view : unpacked_views_) sum += view ? view->size() : 0;
  return sum;
}

}  // namespace bakelight::formats
