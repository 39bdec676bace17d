// All that shines on a pack, as the player takes it: distant light with its picture, and near emitters.
#pragma once

#include <string>

#include "formats/image.h"
#include "formats/light_rig.h"
#include "transport/lights.h"

namespace bakelight::player {

struct Lighting {
  formats::Image backdrop;     // lat-long, channels R, G, B: the distant light as it is seen
  transport::ShLight distant;  // order² coefficients, after windowing
  double window = 0;           // strength of the window against ringing that was used
  double moved_energy = 0;     // what it took away (transport/windowing.h)
  formats::LightRig near;      // emitters only
  int cube_resolution = 64;    // texels along an edge of the cube map that they are drawn into
};

// An environment image. Throws Error(kBadInput) naming `file` for what transport::projectLatLong throws for,
// and for light that is not finite.
Lighting lightingFromImage(const formats::Image& image, int order, const std::string& file,
                           double windowing = 0);

// A light rig, distant lights and emitters. Throws Error(kBadInput) naming `file` for one without any light,
// and for light that is not finite.
Lighting lightingFromRig(formats::LightRig rig, int order, const std::string& file);

// transport::defaultLight, and an image of it: its SH sum, black where that is negative.
Lighting defaultLighting(int order, double windowing = 0);

}  // namespace bakelight::player
