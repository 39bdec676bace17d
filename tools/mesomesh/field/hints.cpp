#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/json_members.h"
#include "tools/mesomesh/field/direction_field.h"
#include "transport/vector_types.h"

namespace bakelight::mesomesh {
namespace {

constexpr double kFarthest = 1e18;
constexpr const char* kExpected = "a list of {\"point\": [x, y, z], \"direction\": [x, y, z]}";

}  // namespace

std::vector<DirectionHint> readHints(const std::filesystem::path& path) {
  const std::string file = path.string();
  const formats::Json json = formats::readJson(path);
  if (!json.is_array()) throw badInput({file, "", ""}, std::string("is ") + json.type_name(), kExpected);
  std::vector<DirectionHint> hints;
  for (std::size_t i = 0; i < json.size(); ++i) {
    formats::JsonMembers members(json[i], file, formats::childPointer("", std::to_string(i)));
    DirectionHint hint = {};
    for (const auto& [name, value] :
         {std::pair("point", &hint.point), std::pair("direction", &hint.direction)}) {
      members.require(name, "[x, y, z]");
      members.read(name, *value, {-kFarthest, kFarthest});
    }
    members.refuseOthers();
    if (!(transport::vec3(hint.direction).norm() > 0))
      throw badInput(members.placeOf("direction"), "the direction has no length", "[x, y, z], not all 0");
    hints.push_back(hint);
  }
  return hints;
}

}  // namespace bakelight::mesomesh
