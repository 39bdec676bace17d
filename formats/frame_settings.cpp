#include "formats/frame_settings.h"

#include <nlohmann/json.hpp>

#include "formats/json_reader.h"

namespace bakelight::formats {

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

}  // namespace

Json toJson(const FrameSettings& settings) {
  Json json = {{"auto_exposure", settings.auto_exposure},
               {"background", wordFor(kBackgrounds, settings.background)}};
  forEachNumber(settings, [&](const char* name, const auto& member, double, double) { json[name] = member; });
  return json;
}

FrameSettings frameSettingsFromJson(const Json& json, const std::string& file, const std::string& pointer) {
  const JsonReader object(json, file, pointer);
  FrameSettings settings;
  forEachNumber(settings, [&](const char* name, auto& member, double least, double greatest) {
    object.read(name, member, {least, greatest});
  });
  object.read("auto_exposure", settings.auto_exposure);
  object.read("background", settings.background, kBackgrounds);
  object.refuseOthers();
  return settings;
}

}  // namespace bakelight::formats
