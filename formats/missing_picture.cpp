#include "formats/missing_picture.h"

#include <fmt/format.h>

namespace bakelight::formats {

std::string missingPicture(const std::string& place, const std::string& picture, const std::string& material,
                           const std::optional<Float3>& color) {
  const std::string has =
      color ? fmt::format("its own colour ({:g}, {:g}, {:g}) alone", (*color)[0], (*color)[1], (*color)[2])
            : "no colour of its own";
  return fmt::format(
      "{}: the picture '{}' does not exist, so the material '{}' has {}; put the picture there", place,
      picture, material, has);
}

}  // namespace bakelight::formats
