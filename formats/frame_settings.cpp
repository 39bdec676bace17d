#include "formats/frame_settings.h"

namespace bakelight::formats {

const std::vector<std::string>& backgroundNames() {
  static const std::vector<std::string> kNames = {"environment", "black", "transparent"};
  return kNames;
}

Background backgroundNamed(const std::string& name) {
  if (name == "black") return Background::kBlack;
  return name == "transparent" ? Background::kTransparent : Background::kEnvironment;
}

}  // namespace bakelight::formats
