// What all `.btf` files begin with. Private to formats/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/btf.h"
#include "formats/btf_cursor.h"

namespace bakelight::formats {

enum class BtfLayout { kDecorrelated, kFullMatrix, kPerView, kRaw };

struct BtfSignature {
  const char* text;
  BtfLayout layout;
  bool has_rotations;
  bool is_extended;  // FMF: of version, dynamic range and heights
};
// Null if the bytes begin with none. The longest that fits.
const BtfSignature* btfSignatureOf(std::span<const std::byte> bytes);
inline constexpr std::size_t kLongestBtfSignature = 10;

struct BtfHeader {
  BtfInfo info;
  std::vector<std::string> channels;  // names
};

// Meta data; then views and lights.
void readBtfMeta(BtfCursor& cursor, BtfHeader& header);
void readBtfSampling(BtfCursor& cursor, BtfInfo& info);
void readBtfSize(BtfCursor& cursor, BtfInfo& info);
// A frame a texel: values stay in it, and that is noted.
void readBtfRotations(BtfCursor& cursor, BtfInfo& info);
// Meta data, sampling, size, and rotations if the signature says so.
void readBtfHeader(BtfCursor& cursor, const BtfSignature& signature, BtfHeader& header);

}  // namespace bakelight::formats
