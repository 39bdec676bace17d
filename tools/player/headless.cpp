#include "tools/player/headless.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "tools/player/gl_context.h"
#include "tools/player/renderer.h"

namespace bakelight::player {
namespace {

constexpr std::size_t kFewest = 3, kMost = 9;
constexpr double kEnough_ms = 1000;

// Runs `work` until enough is known of its time: a GPU's frames vary more than a software renderer's, which
// take so long that a few will do.
template <class Work>
Times_ms timesOf(const Work& work) {
  std::vector<double> times;
  double spent = 0;
  while (times.size() < kFewest || (times.size() < kMost && spent < kEnough_ms)) {
    glFinish();
    const auto start = std::chrono::steady_clock::now();
    work();
    glFinish();
    times.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    spent += times.back();
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
