// Entropy coding of small numbers (Draco's symbol coder, rANS), for tables whose size is to be what a file of them would have.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace bakelight::formats {

// The count, then blocks of the coder. The same symbols give the same bytes. Throws std::invalid_argument for symbols of 2³¹ or more.
std::vector<std::uint8_t> encodeSymbols(std::span<const std::uint32_t> symbols);

// Of bytes that encodeSymbols made and nobody changed.
std::vector<std::uint32_t> decodeSymbols(std::span<const std::uint8_t> bytes);

// Small in magnitude, small as a symbol: 0, −1, 1, −2, …
constexpr std::uint32_t symbolOf(std::int32_t value) {
  return value < 0 ? ~static_cast<std::uint32_t>(value) * 2 + 1 : static_cast<std::uint32_t>(value) * 2;
}
constexpr std::int32_t valueOf(std::uint32_t symbol) {
  return symbol % 2 == 1 ? ~static_cast<std::int32_t>(symbol / 2) : static_cast<std::int32_t>(symbol / 2);
}

}  // namespace bakelight::formats
