// What is true of every pack, before it is written and after it was read. Private to formats/pack*.cpp.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>

#include "formats/pack_contents.h"

namespace bakelight::formats {

inline constexpr int kMaxAngles = 65536;

// Throws Error(kBadInput) naming `file` and the section, vertex or triangle that is wrong.
void checkPack(const Pack& pack, const std::string& file);

// Empty if the product passes 64 bits.
std::optional<std::uint64_t> checkedProduct(std::initializer_list<std::uint64_t> factors);

}  // namespace bakelight::formats
