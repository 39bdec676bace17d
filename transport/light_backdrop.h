// The distant lights of a rig as a picture. Private to transport/light_rig.cpp and its tests.
#pragma once

#include <Eigen/Core>

#include "formats/light_rig.h"

namespace bakelight::transport {

// RigLight::backdrop. Shapes are drawn with antialiased edges and their exact solid angle; a directional
// light is one texel. The same bytes whatever the number of threads.
formats::Image drawBackdrop(const formats::LightRig& rig);

// World direction = this × direction in the environment's image.
Eigen::Matrix3d worldFromEnvironment(const formats::EnvironmentLight& light);

}  // namespace bakelight::transport
