#include "tools/player/headless.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "tools/player/gl_context.h"
#include "tools/player/renderer.h"

namespace bakelight::player {
namespace {

template <class Work>
Times_ms timesOf(const Work& work) {
  std::array<double, 9> times{};
  for (double& time : times) {
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    work();
    glFinish();
    time = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }
  std::ranges::sort(times);
  return {times[times.size() / 2], times[times.size() / 4], times[3 * times.size() / 4]};
}

}  // namespace

HeadlessPicture renderHeadless(const formats::Pack& pack, const transport::Lighting& lighting,
                               const formats::FrameSettings& settings, PictureEncoding encoding) {
  const HeadlessContext context;
  Renderer renderer(pack, lighting);
  HeadlessPicture picture;
  picture.gl_renderer = glRendererName();
  picture.exposure = renderer.exposure(settings);
  picture.light_change_ms = timesOf([&] { renderer.updateLight(settings); });
  if (renderer.hasEmitters()) picture.cube_ms = timesOf([&] { renderer.updateNearLight(settings); });
  picture.gpu_bytes = renderer.gpuBytes();
  picture.frame_ms = timesOf([&] {
    renderer.draw(settings);
    picture.image = encoding == PictureEncoding::kDisplay ? renderer.target().displayImage(picture.exposure)
                                                          : renderer.target().linearImage();
  });
  return picture;
}

}  // namespace bakelight::player
