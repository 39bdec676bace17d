// All that shines on a pack, as evaluation takes it: distant light with its picture, and near emitters.
#pragma once

#include <string>

#include "formats/image.h"
#include "formats/light_rig.h"
#include "transport/lights.h"

namespace bakelight::transport {

struct Lighting {
  formats::Image backdrop;  // lat-long, channels R, G, B: the distant light as it is seen
  ShLight distant;          // order² coefficients, after windowing
  std::vector<formats::DistantLight>
      sources;               // what `distant` stands for, for those who take it in other forms
  double window = 0;         // strength of the window against ringing that was used
  double moved_energy = 0;   // what it took away (transport/windowing.h)
  formats::LightRig near;    // emitters and punctual lights only
  int cube_resolution = 64;  // texels along an edge of the cube map that they are drawn into
};

// An environment image. Throws Error(kBadInput) naming `file` for what projectLatLong throws for,
// and for light that is not finite.
Lighting lightingFromImage(const formats::Image& image, int order, const std::string& file,
                           double windowing = 0);

// A light rig, distant lights and emitters. Throws Error(kBadInput) naming `file` for light that is not
// finite.
Lighting lightingFromRig(formats::LightRig rig, int order, const std::string& file);

// defaultLight, and an image of it: its SH sum, black where that is negative.
Lighting defaultLighting(int order, double windowing = 0);

// Of what formats::readLights reads: the default light for a rig without any; an environment image alone
// keeps its own texels as backdrop.
Lighting lightingFor(formats::LightRig rig, int order, const std::string& file);

}  // namespace bakelight::transport
