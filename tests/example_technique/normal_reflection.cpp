#include "tests/example_technique/normal_reflection.h"

namespace bakelight::example {

void NormalReflection::describe(formats::FieldVisitor& fields) {
  fields.image("picture", picture);
  fields.require(picture.channels == std::vector<std::string>{"R", "G", "B"}, "picture",
                 "its channels are others", "R, G and B", "");
  fields.require(
      picture.width == picture.height, "picture",
      "it has " + std::to_string(picture.width) + " × " + std::to_string(picture.height) + " texels",
      "a square, which the ball fills", "cutting the ball out");
}

const NormalReflection* normalReflectionOf(const formats::Pack& pack) {
  return pack.appearances.size() == 1 ? pack.appearances.front().reflection.as<NormalReflection>() : nullptr;
}

}  // namespace bakelight::example
