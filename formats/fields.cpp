#include "formats/fields.h"

#include <fmt/format.h>

namespace bakelight::formats {
namespace {

std::string shortText(double value) {
  return fmt::format("{:g}", value);
}

}  // namespace

const char* nameOfIntegers(std::size_t width) {
  return width == 1 ? "uint8" : width == 2 ? "uint16" : "uint32";
}

std::string textOf(const Range& range) {
  const Range any;
  if (range.least == any.least && range.greatest == any.greatest) return "a finite number";
  const std::string least = shortText(range.least);
  if (range.greatest == any.greatest) return range.above ? "above " + least : least + " or more";
  return (range.above ? "above " : "") + least + " to " + shortText(range.greatest);
}

}  // namespace bakelight::formats
