#include "formats/symbol_code.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>

#include <algorithm>
#include <stdexcept>

namespace bakelight::formats {
namespace {

constexpr std::size_t kMostAtOnce = std::size_t{1} << 24;  // Draco counts in int

}  // namespace

std::vector<std::uint8_t> encodeSymbols(std::span<const std::uint32_t> symbols) {
  if (std::any_of(symbols.begin(), symbols.end(), [](std::uint32_t symbol) { return symbol >> 31 != 0; }))
    throw std::invalid_argument("encodeSymbols: a symbol of 2³¹ or more");
  draco::EncoderBuffer buffer;
  buffer.Encode(static_cast<std::uint64_t>(symbols.size()));
  for (std::size_t begin = 0; begin < symbols.size(); begin += kMostAtOnce) {
    const std::size_t count = std::min(kMostAtOnce, symbols.size() - begin);
    if (!draco::EncodeSymbols(symbols.data() + begin, static_cast<int>(count), 1, nullptr, &buffer))
      throw std::logic_error("symbols that cannot be coded");
  }
  return {buffer.data(), buffer.data() + buffer.size()};
}

std::vector<std::uint32_t> decodeSymbols(std::span<const std::uint8_t> bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size(), DRACO_BITSTREAM_VERSION(2, 2));
  std::uint64_t count = 0;
  if (!buffer.Decode(&count)) throw std::invalid_argument("decodeSymbols: no code");
  std::vector<std::uint32_t> symbols(count);
  for (std::size_t begin = 0; begin < count; begin += kMostAtOnce)
    if (!draco::DecodeSymbols(static_cast<std::uint32_t>(std::min<std::size_t>(kMostAtOnce, count - begin)),
                              1, &buffer, symbols.data() + begin))
      throw std::invalid_argument("decodeSymbols: a broken code");
  return symbols;
}

}  // namespace bakelight::formats
