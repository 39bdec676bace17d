#include "formats/fields.h"

#include <array>
#include <cstdio>

namespace bakelight::formats {
namespace {

std::string shortText(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

}  // namespace

std::string textOf(const Range& range) {
  const Range any;
  if (range.least == any.least && range.greatest == any.greatest) return "a finite number";
  const std::string least = shortText(range.least);
  if (range.greatest == any.greatest) return range.above ? "above " + least : least + " or more";
  return (range.above ? "above " : "") + least + " to " + shortText(range.greatest);
}

}  // namespace bakelight::formats
