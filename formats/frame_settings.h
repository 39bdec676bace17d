// What a picture of a pack shows, as plain data: the player, the path tracer and the report share it, so that
// their pictures coincide. transport/frame.h turns it into cameras and rotations.
#pragma once

#include <string>

#include "formats/json.h"
#include "formats/words.h"

namespace bakelight::formats {

enum class Background { kEnvironment, kBlack, kTransparent };

inline constexpr Word<Background> kBackgrounds[] = {{"environment", Background::kEnvironment},
                                                    {"black", Background::kBlack},
                                                    {"transparent", Background::kTransparent}};

struct FrameSettings {
  int width_px = 1280, height_px = 960;
  int supersampling = 2;                // subsamples per axis, box-filtered in linear radiance; 1–4
  double yaw_deg = 25, pitch_deg = 15;  // of the camera, see transport::OrbitCamera
  double distance = 1;                  // 1: the object's bounding sphere just fits
  double field_of_view_deg = 35;        // vertical
  double light_yaw_deg = 0, light_pitch_deg = 0;    // turn the distant light; emitters stay
  double object_yaw_deg = 0, object_pitch_deg = 0;  // turn the object about its middle; all light stays
  double time_s = 0;                                // of moving emitters
  bool auto_exposure = true;
  double exposure_ev = 0;  // stops above the automatic exposure, or above 1 without it
  Background background = Background::kEnvironment;
};

// All settings, under the names of the player's parameters ("width", "yaw_deg", …, "auto_exposure",
// "exposure_ev").
Json toJson(const FrameSettings& settings);
// What is not there keeps its default. Throws Error(kBadInput) at `pointer` of `file` for an unknown key
// (with the nearest valid one), a wrong type or a value that the player would refuse.
FrameSettings frameSettingsFromJson(const Json& json, const std::string& file, const std::string& pointer);

}  // namespace bakelight::formats
