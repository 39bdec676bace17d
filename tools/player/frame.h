// What a picture of a pack shows, free of GL: camera, turned light and object, and exposure from a few plain
// settings.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/pack.h"
#include "transport/camera.h"
#include "transport/lights.h"

namespace bakelight::player {

enum class Background { kEnvironment, kBlack, kTransparent };

// "environment", "black", "transparent"; one of them turned into its value.
const std::vector<std::string>& backgroundNames();
Background backgroundNamed(const std::string& name);

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

// Orbits the mesh's bounding sphere at `distance` times the framing distance of transport::frameSphere.
transport::OrbitCamera frameCamera(const FrameSettings& settings, const transport::BoundingSphere& bounds);

// Turns light directions into world directions: about +Y by the yaw, then about +X by the pitch, both
// right-handed.
Eigen::Matrix3d worldFromLight(const FrameSettings& settings);

// The same of the object: world directions of what an unturned object has in its own space.
Eigen::Matrix3d worldFromObject(const FrameSettings& settings);

// The factor on radiance before display encoding. Automatic: the mean radiance (luminance, Rec. 709) of all
// light, which a white object returns on average, goes to kMiddleValue. `light` is the distant light, plus
// the near one as it is at time 0 for an unturned object, so exposure depends on the lights alone, and stays
// while they, the camera or the object move.
inline constexpr double kMiddleValue = 0.32;
double exposureFactor(const FrameSettings& settings, const transport::ShLight& light);

}  // namespace bakelight::player
