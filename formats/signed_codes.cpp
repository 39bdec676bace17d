#include "formats/signed_codes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "formats/error.h"

namespace bakelight::formats {

EncodedTable encodeSigned(std::span<const float> values, std::size_t columns, const std::string& file,
                          const std::string& what) {
  if (columns == 0 || values.size() % columns != 0)
    throw std::invalid_argument("a table's values are no whole number of rows");
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw badInput({file, what + ", row " + std::to_string(i / columns), ""}, "a value is not finite",
                     "numbers", "make the file again");
  EncodedTable table{Precision::kUint8, values.size() / columns, columns, {}, {}, {}};
  std::vector<float> largest(columns, 0.0F);
  for (std::size_t i = 0; i < values.size(); ++i)
    largest[i % columns] = std::max(largest[i % columns], std::abs(values[i]));
  for (const float magnitude : largest) {
    table.scale.push_back(magnitude / kSignedMiddle);
    table.offset.push_back(-kSignedMiddle * table.scale.back());
  }
  Bytes data(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float scale = table.scale[i % columns];
    const int code = scale > 0 ? static_cast<int>(std::lround(values[i] / scale)) : 0;
    data[i] = static_cast<std::byte>(std::clamp(code, -kSignedMiddle, kSignedMiddle) + kSignedMiddle);
  }
  table.data = std::move(data);
  return table;
}

bool isSigned(const EncodedTable& table) {
  if (table.precision != Precision::kUint8 || table.scale.size() != table.columns) return false;
  for (std::size_t c = 0; c < table.columns; ++c)
    if (table.offset[c] != -kSignedMiddle * table.scale[c]) return false;
  return std::none_of(table.data.begin(), table.data.end(),
                      [](std::byte code) { return code == std::byte{255}; });
}

}  // namespace bakelight::formats
