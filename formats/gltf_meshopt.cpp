// EXT_meshopt_compression.
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "formats/gltf_document.h"

namespace bakelight::formats {
namespace {

struct Layout {
  std::size_t count, stride;
};

// The least bytes that `layout` can be packed in, by the formats' own block headers: vertices take at least 2
// bits for 16 bytes, triangles 1 byte for 3 indices, sequences 1 byte an index.
std::uint64_t leastBytes(const Layout& layout, const std::string& mode) {
  if (mode == "ATTRIBUTES") return std::uint64_t{layout.count} * layout.stride / 64;
  return mode == "TRIANGLES" ? layout.count / 3 : layout.count;
}

Layout readLayout(const JsonReader& packed, const std::string& mode, std::size_t packed_size) {
  const JsonReader count = packed.at("count"), stride = packed.at("byteStride");
  const bool vertices = mode == "ATTRIBUTES";
  const std::uint64_t step = stride.whole();
  if (vertices ? step == 0 || step > 256 || step % 4 != 0 : step != 2 && step != 4) {
    throw stride.error(std::to_string(step) + " is no size of an element",
                       vertices ? "a multiple of 4 up to 256" : "2 or 4");
  }
  // The first two make the product below safe.
  if (count.whole() > std::uint64_t{packed_size} * 64 || count.whole() > 0xFFFFFFFFU ||
      leastBytes({static_cast<std::size_t>(count.whole()), static_cast<std::size_t>(step)}, mode) >
          packed_size) {
    throw count.error(std::to_string(count.whole()) + " elements do not fit the compressed bytes",
                      "a count that agrees with byteLength");
  }
  if (mode == "TRIANGLES" && count.whole() % 3 != 0) {
    throw count.error(std::to_string(count.whole()) + " is no multiple of 3", "three indices a triangle");
  }
  return {static_cast<std::size_t>(count.whole()), static_cast<std::size_t>(step)};
}

void applyFilter(const JsonReader& packed, const Layout& layout, Bytes& bytes) {
  const std::string filter = packed.text("filter", "NONE");
  const auto check = [&](bool fits, const char* expected) {
    if (!fits) throw packed.at("byteStride").error("it does not fit the filter " + filter, expected);
  };
  if (filter == "OCTAHEDRAL") {
    check(layout.stride == 4 || layout.stride == 8, "4 or 8");
    meshopt_decodeFilterOct(bytes.data(), layout.count, layout.stride);
  } else if (filter == "QUATERNION") {
    check(layout.stride == 8, "8");
    meshopt_decodeFilterQuat(bytes.data(), layout.count, layout.stride);
  } else if (filter == "EXPONENTIAL") {
    check(layout.stride % 4 == 0, "a multiple of 4");
    meshopt_decodeFilterExp(bytes.data(), layout.count, layout.stride);
  } else if (filter != "NONE") {
    throw packed.at("filter").error("'" + filter + "' is no filter",
                                    "NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
  }
}

int decode(const std::string& mode, const Layout& layout, std::span<const std::byte> packed, Bytes& bytes) {
  const auto* source = reinterpret_cast<const unsigned char*>(packed.data());
  if (mode == "ATTRIBUTES") {
    return meshopt_decodeVertexBuffer(bytes.data(), layout.count, layout.stride, source, packed.size());
  }
  if (mode == "TRIANGLES") {
    return meshopt_decodeIndexBuffer(bytes.data(), layout.count, layout.stride, source, packed.size());
  }
  return meshopt_decodeIndexSequence(bytes.data(), layout.count, layout.stride, source, packed.size());
}

}  // namespace

std::optional<Bytes> meshoptDecoded(const JsonReader& view, GltfDocument& document) {
  const auto packed = extensionOf(view, "EXT_meshopt_compression");
  if (!packed) return std::nullopt;
  const JsonReader mode = packed->at("mode"), length = packed->at("byteLength");
  if (mode.text() != "ATTRIBUTES" && mode.text() != "TRIANGLES" && mode.text() != "INDICES") {
    throw mode.error("'" + mode.text() + "' is no mode", "ATTRIBUTES, TRIANGLES or INDICES");
  }
  const auto source =
      document.bufferBytes(packed->at("buffer"), packed->whole("byteOffset", 0), length.whole(), length);
  const Layout layout = readLayout(*packed, mode.text(), source.size());
  Bytes bytes(layout.count * layout.stride);
  if (const int status = decode(mode.text(), layout, source, bytes); status != 0) {
    throw packed->error("meshoptimizer cannot decode it (status " + std::to_string(status) + ")",
                        "bytes that EXT_meshopt_compression describes");
  }
  if (mode.text() == "ATTRIBUTES") applyFilter(*packed, layout, bytes);
  if (const JsonReader whole = view.at("byteLength"); whole.whole() != bytes.size()) {
    throw whole.error("the compressed view holds " + std::to_string(bytes.size()) + " bytes, not " +
                          std::to_string(whole.whole()),
                      "count times byteStride of the compression");
  }
  return bytes;
}

}  // namespace bakelight::formats
