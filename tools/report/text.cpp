#include "tools/report/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace bakelight::report {
namespace {

std::string withoutTrailingZeros(std::string text) {
  if (text.find('.') == std::string::npos || text.find('e') != std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::pair<double, const char*> scaledBytes(double bytes) {
  constexpr std::array<const char*, 5> kUnits = {"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  for (; bytes >= 999.5 && unit + 1 < kUnits.size(); ++unit) bytes /= 1000;
  return {bytes, kUnits[unit]};
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  return result;
}

std::string numberText(double value, int digits) {
  if (value == 0 || !std::isfinite(value)) return value == 0 ? "0" : "–";
  const double magnitude = std::abs(value);
  if (magnitude < 1e-4 || magnitude >= 1e7) return fmt::format("{:.{}e}", value, digits - 1);
  // Where rounding carries over, as from 9.996 to 10.0, one decimal less is left.
  const std::string rounded = fmt::format("{:.{}e}", magnitude, digits - 1);
  const int exponent = std::stoi(rounded.substr(rounded.find('e') + 1));
  return fmt::format("{:.{}f}", value, std::max(digits - 1 - exponent, 0));
}

std::string tickText(double value) {
  return withoutTrailingZeros(numberText(value, 2));
}

std::string percentText(double share) {
  return numberText(100 * share) + " %";
}

std::string bytesText(std::uint64_t bytes) {
  const auto [value, unit] = scaledBytes(static_cast<double>(bytes));
  return (bytes < 1000 ? std::to_string(bytes) : numberText(value)) + ' ' + unit;
}

std::string bytesTickText(double bytes) {
  const auto [value, unit] = scaledBytes(bytes);
  return tickText(value) + ' ' + unit;
}

std::string coordinate(double value) {
  const std::string text = withoutTrailingZeros(fmt::format("{:.2f}", value));
  return text == "-0" ? "0" : text;
}

std::string valueText(const formats::Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

}  // namespace bakelight::report
