#include "tools/player/headless.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gpu_timer.h"
#include "tools/player/renderer.h"

namespace bakelight::player {
namespace {

constexpr std::size_t kFewest = 3, kMost = 9;
constexpr double kEnough_ms = 1000;

// Runs `once`, which returns what it took, until enough is known of it: a GPU's frames vary more than a
// software renderer's, which take so long that a few will do.
template <class Once>
void repeat(const Once& once) {
  double spent_ms = 0;
  for (std::size_t runs = 0; runs < kFewest || (runs < kMost && spent_ms < kEnough_ms); ++runs)
    spent_ms += once();
}

Times_ms spreadOf(std::vector<double> times) {
  std::ranges::sort(times);
  return {times[times.size() / 2], times[times.size() / 4], times[3 * times.size() / 4]};
}

template <class Work>
double millisecondsOf(const Work& work) {
  glFinish();
  const auto start = std::chrono::steady_clock::now();
  work();
  glFinish();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

using NamedTimes = std::vector<std::pair<std::string, std::vector<double>>>;

void add(const GpuTimes& times, NamedTimes& passes) {
  for (const auto& [name, pass_ms] : times.passes_ms) {
    const auto known = std::ranges::find(passes, name, &NamedTimes::value_type::first);
    if (known == passes.end())
      passes.push_back({name, {pass_ms}});
    else
      known->second.push_back(pass_ms);
  }
}

// In runs of their own, since passes that are told apart take longer together; `run_ms` is what one takes
// otherwise.
template <class Work>
std::vector<std::pair<std::string, double>> passTimesOf(const Work& work, double run_ms) {
  NamedTimes passes;
  GpuTimer timer;
  const std::size_t runs = run_ms < kEnough_ms / kFewest ? kFewest : 1;
  for (std::size_t run = 0; run < runs; ++run) {
    timer.start(GpuTimer::Of::kPasses);
    work();
    add(timer.finish(), passes);
  }
  std::vector<std::pair<std::string, double>> medians;
  for (auto& [name, times] : passes) medians.emplace_back(name, spreadOf(std::move(times)).median);
  return medians;
}

template <class Work>
WorkTimes timesOf(const Work& work) {
  std::vector<double> wall, gpu;
  GpuTimer timer;
  repeat([&] {
    wall.push_back(millisecondsOf([&] {
      timer.start(GpuTimer::Of::kTotal);
      work();
      gpu.push_back(timer.finish().total_ms);
    }));
    return wall.back();
  });
  const Times_ms spread = spreadOf(std::move(wall));
  return {spread, spreadOf(std::move(gpu)), passTimesOf(work, spread.median)};
}

Times_ms readBackTimes(const ResolvedPicture& resolved, formats::Image& image) {
  std::vector<double> times;
  repeat([&] { return times.emplace_back(millisecondsOf([&] { image = resolved.read(); })); });
  return spreadOf(std::move(times));
}

}  // namespace

HeadlessPicture renderHeadless(const formats::Pack& pack, const transport::Lighting& lighting,
                               const formats::FrameSettings& settings, PictureEncoding encoding,
                               const SurroundingsOptions& surroundings) {
  const HeadlessContext context;
  Renderer renderer(pack, lighting, surroundings);
  HeadlessPicture picture;
  picture.gl_renderer = glRendererName();
  picture.exposure = renderer.exposure(settings);
  picture.light_change = timesOf([&] { renderer.updateLight(settings); });
  if (renderer.hasNearLights()) picture.cube = timesOf([&] { renderer.updateNearLight(settings); });
  picture.gpu_bytes = renderer.gpuBytes();
  renderer.draw(settings);
  const ResolvedPicture resolved(encoding, settings.width_px, settings.height_px);
  picture.frame = timesOf([&] {
    renderer.draw(settings);
    renderer.target().resolve(resolved, picture.exposure);
  });
  picture.read_back = readBackTimes(resolved, picture.image);
  return picture;
}

}  // namespace bakelight::player
