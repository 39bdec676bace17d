// Tables of 8-bit codes about a middle that stands for 0, as hardware has signed bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "formats/encoded_table.h"

namespace bakelight::formats {

// Codes are 0 to 254, and this one is 0: offset = −127 · scale.
inline constexpr int kSignedMiddle = 127;

// kUint8; errs by half a step at most, a 254th of the column's largest magnitude. Throws Error(kBadInput) naming `file` and `what` for a value
// that is not finite.
EncodedTable encodeSigned(std::span<const float> values, std::size_t columns, const std::string& file,
                          const std::string& what);
bool isSigned(const EncodedTable& table);

}  // namespace bakelight::formats
