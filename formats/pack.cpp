#include "formats/pack.h"

#include <stdexcept>

#include "formats/glb.h"
#include "formats/pack_check.h"
#include "formats/pack_layout.h"

namespace bakelight::formats {
namespace {

void checkOptions(const PackOptions& options) {
  const auto isValid = [](int bits, int least) { return bits == 0 || (bits >= least && bits <= 30); };
  if (!isValid(options.position_bits, 8) || !isValid(options.normal_bits, 6)) {
    throw std::logic_error("Draco's bits are out of range");
  }
}

}  // namespace

std::vector<Float2> flippedTexcoords(const std::vector<Float2>& texcoords) {
  std::vector<Float2> result;
  result.reserve(texcoords.size());
  for (const Float2& t : texcoords) result.push_back({t[0], 1 - t[1]});
  return result;
}

Bytes encodePack(const Pack& pack, const PackOptions& options, const std::string& file) {
  checkOptions(options);
  checkPack(pack, file);
  return encodeCheckedPack(pack, options, file);
}

Pack decodePack(std::span<const std::byte> bytes, const std::string& file) {
  const GlbReader glb(bytes, file);
  Pack pack = decodeUncheckedPack(glb);
  checkPack(pack, file);
  return pack;
}

void writePack(const std::filesystem::path& path, const Pack& pack, const PackOptions& options) {
  writeFileAtomically(path, encodePack(pack, options, path.string()));
}

Pack readPack(const std::filesystem::path& path) {
  Pack pack = decodeUncheckedPack(GlbReader(MappedFile::open(path), path.string()));
  checkPack(pack, path.string());
  return pack;
}

std::vector<PackSection> packSections(std::span<const std::byte> bytes, const std::string& file) {
  return GlbReader(bytes, file).sections();
}

int packVersion(std::span<const std::byte> bytes, const std::string& file) {
  return GlbReader(bytes, file).version();
}

}  // namespace bakelight::formats
