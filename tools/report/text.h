// Text of the report's page: escaped, and numbers as people read them. Never by the locale.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/json.h"

namespace bakelight::report {

// For element content and quoted attributes of HTML and SVG.
std::string escaped(std::string_view text);

// So many significant digits, without exponent from 1e-4 to 1e7: "0.0312", "12,300" is "12300".
std::string numberText(double value, int digits = 3);
// The same of a tick: two digits at most, no trailing zeros.
std::string tickText(double value);
std::string percentText(double share);       // 0.0312 → "3.12 %"
std::string bytesText(std::uint64_t bytes);  // powers of 1000: "1.23 MB"
std::string bytesTickText(double bytes);     // "1.2 MB"
// For coordinates: two decimals at most, no trailing zeros.
std::string coordinate(double value);
// A parameter's value: texts as they are, anything else as JSON.
std::string valueText(const formats::Json& value);

}  // namespace bakelight::report
