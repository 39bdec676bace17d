#include "formats/frame_settings.h"

#include <nlohmann/json.hpp>

#include "formats/tool_description.h"

namespace bakelight::formats {

const std::vector<std::string>& backgroundNames() {
  static const std::vector<std::string> kNames = {"environment", "black", "transparent"};
  return kNames;
}

Background backgroundNamed(const std::string& name) {
  if (name == "black") return Background::kBlack;
  return name == "transparent" ? Background::kTransparent : Background::kEnvironment;
}

namespace {

// Calls visit(name, member, least, greatest) for each number.
template <class Settings, class Visit>
void forEachNumber(Settings& settings, const Visit& visit) {
  visit("width", settings.width_px, 1, 16384);
  visit("height", settings.height_px, 1, 16384);
  visit("supersampling", settings.supersampling, 1, 4);
  visit("yaw_deg", settings.yaw_deg, -360, 360);
  visit("pitch_deg", settings.pitch_deg, -89, 89);
  visit("distance", settings.distance, 0.2, 20);
  visit("field_of_view_deg", settings.field_of_view_deg, 1, 120);
  visit("light_yaw_deg", settings.light_yaw_deg, -360, 360);
  visit("light_pitch_deg", settings.light_pitch_deg, -360, 360);
  visit("object_yaw_deg", settings.object_yaw_deg, -360, 360);
  visit("object_pitch_deg", settings.object_pitch_deg, -360, 360);
  visit("time_s", settings.time_s, 0, 1e6);
  visit("exposure_ev", settings.exposure_ev, -32, 32);
}

ParameterDescription rule(const std::string& name, ParameterType type) {
  ParameterDescription description;
  description.name = name;
  description.type = type;
  return description;
}

// By the same rules as a tool's parameters.
ToolDescription frameDescription() {
  ToolDescription description;
  description.tool = "frame";
  FrameSettings settings;
  forEachNumber(settings, [&](const char* name, auto& member, double least, double greatest) {
    constexpr bool is_integer = std::is_same_v<decltype(member), int&>;
    ParameterDescription number = rule(name, is_integer ? ParameterType::kInteger : ParameterType::kReal);
    number.minimum = least;
    number.maximum = greatest;
    description.parameters.push_back(number);
  });
  description.parameters.push_back(rule("auto_exposure", ParameterType::kBoolean));
  description.parameters.push_back(rule("background", ParameterType::kText));
  description.parameters.back().choices = backgroundNames();
  return description;
}

}  // namespace

Json toJson(const FrameSettings& settings) {
  Json json = {{"auto_exposure", settings.auto_exposure},
               {"background", backgroundNames()[static_cast<std::size_t>(settings.background)]}};
  forEachNumber(settings, [&](const char* name, const auto& member, double, double) { json[name] = member; });
  return json;
}

FrameSettings frameSettingsFromJson(const Json& json, const std::string& file, const std::string& pointer) {
  const Json values = checkParameters(frameDescription(), json, {file, "", pointer});
  FrameSettings settings;
  forEachNumber(settings, [&](const char* name, auto& member, double, double) {
    if (values.contains(name)) values.at(name).get_to(member);
  });
  if (values.contains("auto_exposure")) values.at("auto_exposure").get_to(settings.auto_exposure);
  if (values.contains("background")) settings.background = backgroundNamed(values.at("background"));
  return settings;
}

}  // namespace bakelight::formats
