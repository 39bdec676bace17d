// One frame of a pack without a window.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "formats/image.h"
#include "formats/pack.h"
#include "transport/frame.h"
#include "transport/lighting.h"

namespace bakelight::player {

enum class PictureEncoding {
  kDisplay,  // exposed and sRGB-encoded, values k/255, colour not premultiplied: for PNG
  kLinear,   // linear radiance without exposure, colour premultiplied by coverage: for OpenEXR
};

// Of several runs: the median and the quartiles.
struct Times_ms {
  double median = 0, low = 0, high = 0;
};

struct HeadlessPicture {
  formats::Image image;  // R, G, B, A
  float exposure = 1;    // the factor that display encoding applies
  // Until GL has finished.
  Times_ms light_change_ms;         // turning the distant light and evaluating it at all vertices
  std::optional<Times_ms> cube_ms;  // placing the emitters, drawing their cube map, projecting it; if any
  Times_ms frame_ms;  // reflecting towards the eye, drawing, resolving and reading back, lights unchanged
  std::size_t gpu_bytes = 0;  // of buffers and textures, without the picture
  std::string gl_renderer;
};

// Throws Error(kNotAvailable) without OpenGL 4.5, and what Renderer throws.
HeadlessPicture renderHeadless(const formats::Pack& pack, const transport::Lighting& lighting,
                               const formats::FrameSettings& settings, PictureEncoding encoding);

}  // namespace bakelight::player
