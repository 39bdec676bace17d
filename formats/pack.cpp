#include "formats/pack.h"

#include <stdexcept>

#include "formats/btf_reflection.h"
#include "formats/glb.h"
#include "formats/pack_check.h"
#include "formats/pack_layout.h"
#include "formats/patch_code.h"
#include "formats/rtt_reflection.h"

namespace bakelight::formats {
namespace {

void checkOptions(const PackOptions& options) {
  const auto isValid = [](int bits, int least) { return bits == 0 || (bits >= least && bits <= 30); };
  if (!isValid(options.position_bits, 8) || !isValid(options.normal_bits, 6)) {
    throw std::logic_error("Draco's bits are out of range");
  }
}

Pack checkedAndExpanded(Pack pack, const std::string& file) {
  checkPack(pack, file);
  for (Appearance& appearance : pack.appearances) {
    if (auto* btf = appearance.reflection.as<BtfReflection>(); btf != nullptr) expandPatch(*btf, file);
    if (auto* rtt = appearance.reflection.as<RttReflection>(); rtt != nullptr) expandPatch(*rtt, file);
  }
  return pack;
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
  return checkedAndExpanded(decodeUncheckedPack(glb), file);
}

void writePack(const std::filesystem::path& path, const Pack& pack, const PackOptions& options) {
  writeFileAtomically(path, encodePack(pack, options, path.string()));
}

Pack readPack(const std::filesystem::path& path) {
  return checkedAndExpanded(decodeUncheckedPack(GlbReader(MappedFile::open(path), path.string())),
                            path.string());
}

std::vector<PackSection> packSections(std::span<const std::byte> bytes, const std::string& file) {
  return GlbReader(bytes, file).sections();
}

int packVersion(std::span<const std::byte> bytes, const std::string& file) {
  return GlbReader(bytes, file).version();
}

}  // namespace bakelight::formats
