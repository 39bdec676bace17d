// One frame of a pack without a window.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/image.h"
#include "formats/pack.h"
#include "tools/player/gl/picture_target.h"
#include "tools/player/surroundings/surroundings.h"
#include "transport/frame.h"
#include "transport/lighting.h"

namespace bakelight::player {

// Of several runs: the median and the quartiles.
struct Times_ms {
  double median = 0, low = 0, high = 0;
};

// By the CPU's clock until GL has finished, and by the GPU's own.
struct WorkTimes {
  Times_ms wall, gpu;
  std::vector<std::pair<std::string, double>> gpu_passes_ms;  // medians of runs of their own; see GpuTimer
};

struct HeadlessPicture {
  formats::Image image;    // R, G, B, A
  float exposure = 1;      // the factor that display encoding applies
  WorkTimes light_change;  // turning the distant light and evaluating it
  std::optional<WorkTimes>
      cube;  // placing near lights, drawing and projecting their cube map, casting punctual ones; if any
  WorkTimes frame;            // reflecting towards the eye, drawing and resolving, lights unchanged
  Times_ms read_back;         // of the picture, by the CPU's clock
  std::size_t gpu_bytes = 0;  // of buffers and textures, without the picture
  std::string gl_renderer;
};

// Throws Error(kNotAvailable) without OpenGL 4.5, and what Renderer throws.
HeadlessPicture renderHeadless(const formats::Pack& pack, const transport::Lighting& lighting,
                               const formats::FrameSettings& settings, PictureEncoding encoding,
                               const SurroundingsOptions& surroundings = {});

}  // namespace bakelight::player
