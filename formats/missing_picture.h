// What is told of a picture that a mesh file names and that is not there: the same for all formats.
#pragma once

#include <optional>
#include <string>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// A note. `place`: the file, and line or element, that names the picture. `color`: the material's own, which
// is all that it has without the picture.
std::string missingPicture(const std::string& place, const std::string& picture, const std::string& material,
                           const std::optional<Float3>& color);

}  // namespace bakelight::formats
