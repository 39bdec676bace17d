// Camera, turned light and object, and exposure from a few plain settings.
#pragma once

#include <Eigen/Core>

#include "formats/frame_settings.h"
#include "transport/camera.h"
#include "transport/lights.h"

namespace bakelight::transport {

// Orbits the mesh's bounding sphere at `distance` times the framing distance of frameSphere.
OrbitCamera frameCamera(const formats::FrameSettings& settings, const BoundingSphere& bounds);

// Turns light directions into world directions: about +Y by the yaw, then about +X by the pitch, both
// right-handed.
Eigen::Matrix3d worldFromLight(const formats::FrameSettings& settings);

// The same of the object: world directions of what an unturned object has in its own space.
Eigen::Matrix3d worldFromObject(const formats::FrameSettings& settings);

// The factor on radiance before display encoding. Automatic: the mean radiance (luminance, Rec. 709) of all
// light, which a white object returns on average, goes to kMiddleValue. `light` is the distant light, plus
// the near one as it is at time 0 for an unturned object, so exposure depends on the lights alone, and stays
// while they, the camera or the object move.
inline constexpr double kMiddleValue = 0.32;
double exposureFactor(const formats::FrameSettings& settings, const ShLight& light);

}  // namespace bakelight::transport
