#include "formats/missing_picture.h"

#include <sstream>

namespace bakelight::formats {

std::string missingPicture(const std::string& place, const std::string& picture, const std::string& material,
                           const std::optional<Float3>& color) {
  std::ostringstream text;
  text << place << ": the picture '" << picture << "' does not exist, so the material '" << material
       << "' has ";
  if (color) {
    text << "its own colour (" << (*color)[0] << ", " << (*color)[1] << ", " << (*color)[2] << ") alone";
  } else {
    text << "no colour of its own";
  }
  text << "; put the picture there";
  return text.str();
}

}  // namespace bakelight::formats
