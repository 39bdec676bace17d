// What a picture of a pack shows, free of GL: camera, light and exposure from a few plain settings.
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
  double light_yaw_deg = 0, light_pitch_deg = 0;
  bool auto_exposure = true;
  double exposure_ev = 0;  // stops above the automatic exposure, or above 1 without it
  Background background = Background::kEnvironment;
};

// The light that a pack is played under: an environment image and its projection at the pack's order.
struct Environment {
  formats::Image image;      // lat-long, channels R, G, B
  transport::ShLight light;  // order² coefficients
};

// Throws Error(kBadInput) naming `file` for what transport::projectLatLong throws for, and for light that is
// not finite.
Environment environmentFromImage(formats::Image image, int order, const std::string& file);

// transport::defaultLight, and an image of it: its SH sum, black where that is negative.
Environment defaultEnvironment(int order);

// Orbits the mesh's bounding sphere at `distance` times the framing distance of transport::frameSphere.
transport::OrbitCamera frameCamera(const FrameSettings& settings, const transport::BoundingSphere& bounds);

// Turns light directions into world directions: about +Y by the yaw, then about +X by the pitch, both
// right-handed.
Eigen::Matrix3d worldFromLight(const FrameSettings& settings);

// The factor on radiance before display encoding. Automatic: the light's mean radiance (luminance, Rec. 709),
// which a white object returns on average, goes to kMiddleValue. So it depends on the light alone, not on
// camera or object.
inline constexpr double kMiddleValue = 0.32;
double exposureFactor(const FrameSettings& settings, const transport::ShLight& light);

}  // namespace bakelight::player
