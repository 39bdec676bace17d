#include "formats/hash.h"

#define XXH_INLINE_ALL  // one header-only copy; no symbol clash with other libraries' xxHash
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

std::string hexDigits(std::uint64_t value) {
  return fmt::format("{:016x}", value);
}

std::string hexDigits(const XXH128_hash_t& hash) {
  return hexDigits(hash.high64) + hexDigits(hash.low64);
}

}  // namespace

std::string contentHash(std::span<const std::byte> bytes) {
  return hexDigits(XXH3_128bits(bytes.data(), bytes.size()));
}

std::string contentHash(std::string_view text) {
  return contentHash(std::as_bytes(std::span(text)));
}

std::string contentHashOfFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw badInput({path.string(), "", ""}, "cannot be opened", "a file that can be read",
                   "check the path and its permissions");
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_128bits_reset(state.get());
  std::vector<char> block(1 << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    XXH3_128bits_update(state.get(), block.data(), static_cast<std::size_t>(file.gcount()));
  if (file.bad())
    throw badInput({path.string(), "", ""}, "cannot be read to its end", "a file that can be read",
                   "check that it is a file and that the disk is sound");
  return hexDigits(XXH3_128bits_digest(state.get()));
}

std::uint64_t checksum64(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::string checksumHex(std::span<const std::byte> bytes) {
  return hexDigits(checksum64(bytes));
}

std::string checksumHex(std::span<const std::byte> bytes,
                        const std::function<void(std::span<const std::byte>)>& after_block) {
  constexpr std::size_t kBlock = std::size_t{1} << 24;
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  for (std::size_t first = 0; first < bytes.size(); first += kBlock) {
    const auto block = bytes.subspan(first, std::min(kBlock, bytes.size() - first));
    XXH3_64bits_update(state.get(), block.data(), block.size());
    after_block(block);
  }
  return hexDigits(XXH3_64bits_digest(state.get()));
}

}  // namespace bakelight::formats
