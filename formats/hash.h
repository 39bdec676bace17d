// Content hashes (cache keys) and checksums (damage detection), both by xxHash's XXH3.
// Neither is cryptographic: they guard against accidents, not against an adversary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bakelight::formats {

// XXH3-128 as 32 lowercase hex digits.
std::string contentHash(std::span<const std::byte> bytes);
std::string contentHash(std::string_view text);
// Reads in blocks, so that memory use does not grow with the file. Throws Error(kBadInput) if it cannot be
// read.
std::string contentHashOfFile(const std::filesystem::path& path);

// XXH3-64, and its 16 lowercase hex digits.
std::uint64_t checksum64(std::span<const std::byte> bytes);
std::string checksumHex(std::span<const std::byte> bytes);
// The same in blocks, each of which is handed over after it was read.
std::string checksumHex(std::span<const std::byte> bytes,
                        const std::function<void(std::span<const std::byte>)>& after_block);

}  // namespace bakelight::formats
