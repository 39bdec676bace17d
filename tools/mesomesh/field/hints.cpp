#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/json_reader.h"
#include "tools/mesomesh/field/direction_field.h"
#include "transport/vector_types.h"

namespace bakelight::mesomesh {
namespace {

constexpr formats::NumberRange kRange = {-1e18, 1e18};
constexpr const char* kThree = "[x, y, z]";
constexpr const char* kExpected = "a list of {\"point\": [x, y, z], \"direction\": [x, y, z]}";

}  // namespace

std::vector<DirectionHint> readHints(const std::filesystem::path& path) {
  const std::string file = path.string();
  const formats::Json json = formats::readJson(path);
  std::vector<DirectionHint> hints;
  const formats::JsonReader list(json, file);
  if (!json.is_array()) throw list.error(std::string("is ") + json.type_name(), kExpected);
  for (const formats::JsonReader& entry : list.items()) {
    const DirectionHint hint = {entry.at("point", kThree).float3(kRange),
                                entry.at("direction", kThree).float3(kRange)};
    entry.refuseOthers();
    if (!(transport::vec3(hint.direction).norm() > 0))
      throw badInput(entry.placeOf("direction"), "the direction has no length", "[x, y, z], not all 0");
    hints.push_back(hint);
  }
  return hints;
}

}  // namespace bakelight::mesomesh
