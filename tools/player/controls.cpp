#include "tools/player/controls.h"

#include <algorithm>
#include <cmath>

namespace bakelight::player {
namespace {

constexpr double kDegreesPerPixel = 0.3;

double wrapped(double degrees) {
  return std::remainder(degrees, 360.0);
}

}  // namespace

void dragOrbit(formats::FrameSettings& settings, double dx_px, double dy_px) {
  settings.yaw_deg = wrapped(settings.yaw_deg - kDegreesPerPixel * dx_px);
  settings.pitch_deg = std::clamp(settings.pitch_deg + kDegreesPerPixel * dy_px, -89.0, 89.0);
}

void dragLight(formats::FrameSettings& settings, double dx_px, double dy_px) {
  settings.light_yaw_deg = wrapped(settings.light_yaw_deg + kDegreesPerPixel * dx_px);
  settings.light_pitch_deg = wrapped(settings.light_pitch_deg + kDegreesPerPixel * dy_px);
}

void dragObject(formats::FrameSettings& settings, double dx_px, double dy_px) {
  settings.object_yaw_deg = wrapped(settings.object_yaw_deg + kDegreesPerPixel * dx_px);
  settings.object_pitch_deg = wrapped(settings.object_pitch_deg + kDegreesPerPixel * dy_px);
}

void zoom(formats::FrameSettings& settings, double steps) {
  settings.distance = std::clamp(settings.distance * std::pow(0.9, steps), 0.2, 20.0);
}

}  // namespace bakelight::player
