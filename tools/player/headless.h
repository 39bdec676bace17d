// One frame of a pack without a window.
#pragma once

#include <string>

#include "formats/image.h"
#include "formats/pack.h"
#include "tools/player/frame.h"

namespace bakelight::player {

enum class PictureEncoding {
  kDisplay,  // exposed and sRGB-encoded, values k/255, colour not premultiplied: for PNG
  kLinear,   // linear radiance without exposure, colour premultiplied by coverage: for OpenEXR
};

struct HeadlessPicture {
  formats::Image image;  // R, G, B, A
  float exposure = 1;    // the factor that display encoding applies
  // Medians of five, until GL has finished.
  double light_change_ms = 0;  // rotating the light and evaluating it at all vertices
  double frame_ms = 0;         // drawing, resolving and reading back, with the light unchanged
  std::string gl_renderer;
};

// Throws Error(kNotAvailable) without OpenGL 4.5, and what Renderer throws.
HeadlessPicture renderHeadless(const formats::Pack& pack, const Environment& environment,
                               const FrameSettings& settings, PictureEncoding encoding);

}  // namespace bakelight::player
