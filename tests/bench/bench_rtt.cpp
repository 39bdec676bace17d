// A radiance transfer texture as the paper has it (64 × 64 texels, 8 × 8 views, 128 lights, 2 × 2 samples, shadows), with
// two bounces, beside the ray tracer that it stands on.
//
//   bench_rtt [Google Benchmark flags]
//
// seconds        of the whole: subdivision, tree, light, views.
// raw_ray_ratio  (rays ÷ seconds) ÷ (bare Embree's rays/s for the same rays: those of lights, of bounces and of views, in
//                the same order, against the same triangles, by the best of its packets that were tried). Bake and rival
//                run in turn; medians.
// pyramid_error  largest over the levels: root mean square of (2^l × 2^l texels averaged − the patch rendered at that
//                level's resolution with three times the samples a side, so at other points) ÷ that of the values. Through
//                a texel of level l leaves, towards a view, the mean of what leaves through the texels that it covers:
//                what an ever finer rendering of it converges to.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "formats/material.h"
#include "patch/read_patch.h"
#include "tools/rtt/elements.h"
#include "tools/rtt/rtt.h"
#include "tools/rtt/surface_sides.h"
#include "tools/rtt/view_rays.h"
#include "transport/directions.h"
#include "transport/hemisphere_grid.h"
#include "transport/periodic_ray_scene.h"

namespace bakelight::rtt {
namespace {

using transport::Vec3;
using transport::vec3;
using Clock = std::chrono::steady_clock;

constexpr int kRounds = 3;
constexpr std::size_t kBlock = 64;

double secondsOf(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

patch::PatchGeometry patchOf(const std::string& name) {
  return patch::readPatch(
      formats::readMaterials(std::string(BAKELIGHT_SOURCE_DIR) + "/configs/patches/" + name + ".json").base);
}

Options paperOptions() {
  Options options;
  options.bounces = 2;
  return options;
}

struct RayLists {
  std::vector<transport::FreeRays> any, nearest;  // whether something is met; what is
  std::size_t views = 0;                          // from which of `nearest` on they are those of views
  std::size_t count() const {
    std::size_t sum = 0;
    for (const auto* lists : {&any, &nearest})
      for (const transport::FreeRays& rays : *lists) sum += rays.size();
    return sum;
  }
};

// All rays of a run, in its order, in lists that are worked off one by one.
RayLists raysOf(const patch::PatchGeometry& geometry, const transport::PeriodicRayScene& scene,
                const Options& options) {
  RayLists lists;
  const SurfaceSides sides = surfaceSides(geometry);
  const std::vector<LightDirection> lights =
      lightDirections(options.light_rule, options.polar_lights, options.azimuth_lights, options.order);
  const std::vector<Vec3> directions = transport::sphereDirections(options.bounce_directions);
  for (std::size_t first = 0; first < sides.points.size(); first += kBlock) {
    const auto points = std::span(sides.points).subspan(first, std::min(kBlock, sides.points.size() - first));
    const auto along = [&](const Vec3& direction, transport::FreeRays& rays) {
      for (const transport::SurfacePoint& point : points)
        if (vec3(point.normal).dot(direction) > 0) rays.push(vec3(point.origin), direction);
    };
    lists.any.emplace_back(), lists.nearest.emplace_back();
    for (const LightDirection& light : lights) along(light.towards, lists.any.back());
    for (const Vec3& direction : directions) along(direction, lists.nearest.back());
  }
  lists.views = lists.nearest.size();
  const int height = static_cast<int>(std::lround(options.resolution * geometry.aspect));
  for (int view = 0; view < options.views * options.views; ++view)
    for (int y = 0; y < height; ++y) {
      lists.nearest.emplace_back();
      const Vec3 towards =
          transport::hemisphereCell(options.views, view % options.views, view / options.views);
      rowOfViewRays(geometry, scene, towards, {options.resolution, height, options.supersampling}, y,
                    lists.nearest.back());
    }
  return lists;
}

// Embree without anything of ours around it. Rays go on to infinity: beyond the copies there is nothing.
class BareEmbree {
 public:
  explicit BareEmbree(const formats::TriangleMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                        mesh.vertexCount()),
                mesh.positions.data(), 12 * mesh.vertexCount());
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                        mesh.triangleCount()),
                mesh.triangles.data(), 12 * mesh.triangleCount());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene_);
  }
  ~BareEmbree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareEmbree(const BareEmbree&) = delete;
  BareEmbree& operator=(const BareEmbree&) = delete;

  // Packets of kWidth (1, 8 or 16).
  template <int kWidth>
  double seconds(const RayLists& lists, bool coherent) const {
    return secondsOf([&] { traceAll<kWidth>(lists, coherent); });
  }
  // By packets of 8: of lights, bounces and views.
  std::array<double, 3> secondsByKind(const RayLists& lists) const {
    const auto nearest = [&](std::size_t first, std::size_t end) {
      return secondsOf([&] {
        tbb::parallel_for(first, end, [&](std::size_t i) { trace<8, false>(lists.nearest[i], false); });
      });
    };
    return {secondsOf([&] {
              tbb::parallel_for(std::size_t{0}, lists.any.size(),
                                [&](std::size_t i) { trace<8, true>(lists.any[i], false); });
            }),
            nearest(0, lists.views), nearest(lists.views, lists.nearest.size())};
  }
  std::uint64_t met() const { return met_; }

 private:
  template <int kWidth>
  void traceAll(const RayLists& lists, bool coherent) const {
    tbb::parallel_for(std::size_t{0}, lists.any.size(),
                      [&](std::size_t i) { trace<kWidth, true>(lists.any[i], coherent); });
    tbb::parallel_for(std::size_t{0}, lists.nearest.size(),
                      [&](std::size_t i) { trace<kWidth, false>(lists.nearest[i], coherent); });
  }

  template <int kWidth>
  using RayHit =
      std::conditional_t<kWidth == 1, RTCRayHit, std::conditional_t<kWidth == 8, RTCRayHit8, RTCRayHit16>>;

  template <int kWidth, bool kAny>
  void trace(const transport::FreeRays& rays, bool coherent) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) RayHit<kWidth> query{};
    alignas(64) int valid[kWidth];
    auto* lanes =
        reinterpret_cast<float*>(&query);  // field order of all types: org, tnear, dir, time, tfar, mask
    const auto lane = [&](int field) { return lanes + static_cast<std::ptrdiff_t>(field) * kWidth; };
    std::uint64_t met = 0;
    for (std::size_t first = 0; first < rays.size(); first += kWidth) {
      const int count = static_cast<int>(std::min<std::size_t>(kWidth, rays.size() - first));
      for (int i = 0; i < kWidth; ++i) {
        const std::size_t r = first + static_cast<std::size_t>(std::min(i, count - 1));
        valid[i] = i < count ? -1 : 0;
        lane(0)[i] = rays.x[r], lane(1)[i] = rays.y[r], lane(2)[i] = rays.z[r], lane(3)[i] = 0;
        lane(4)[i] = rays.direction_x[r], lane(5)[i] = rays.direction_y[r], lane(6)[i] = rays.direction_z[r];
        lane(8)[i] = std::numeric_limits<float>::infinity() * static_cast<float>(i < count ? 1 : -1);
        reinterpret_cast<unsigned*>(lane(9))[i] = ~0U;
      }
      if constexpr (kAny) {
        if constexpr (kWidth == 1) rtcOccluded1(scene_, &context, &query.ray);
        if constexpr (kWidth == 8) rtcOccluded8(valid, scene_, &context, &query.ray);
        if constexpr (kWidth == 16) rtcOccluded16(valid, scene_, &context, &query.ray);
        for (int i = 0; i < count; ++i) met += lane(8)[i] < 0 ? 1 : 0;
      } else {
        if constexpr (kWidth == 1) {
          query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
          rtcIntersect1(scene_, &context, &query);
          met += query.hit.geomID != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
        } else {
          std::fill_n(query.hit.geomID, kWidth, RTC_INVALID_GEOMETRY_ID);
          if constexpr (kWidth == 8) rtcIntersect8(valid, scene_, &context, &query);
          if constexpr (kWidth == 16) rtcIntersect16(valid, scene_, &context, &query);
          for (int i = 0; i < count; ++i) met += query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID ? 1 : 0;
        }
      }
    }
    met_ += met;
  }

  RTCDevice device_ = rtcNewDevice(nullptr);
  RTCScene scene_ = rtcNewScene(device_);
  mutable std::atomic<std::uint64_t> met_{0};
};

formats::RadianceTransferTexture averaged(const formats::RadianceTransferTexture& finer) {
  formats::RadianceTransferTexture coarser = finer;
  coarser.width /= 2, coarser.height /= 2;
  coarser.allocate();
  for (int view = 0; view < finer.views * finer.views; ++view)
    for (int y = 0; y < finer.height; ++y)
      for (int x = 0; x < finer.width; ++x) {
        const auto from = finer.response(view % finer.views, view / finer.views, x, y);
        const auto to = coarser.response(view % finer.views, view / finer.views, x / 2, y / 2);
        for (std::size_t i = 0; i < to.size(); ++i) to[i] += from[i] / 4;
      }
  return coarser;
}

double relativeError(const std::vector<float>& values, const std::vector<float>& right) {
  double differences = 0, squares = 0;
  for (std::size_t i = 0; i < right.size(); ++i) {
    differences += std::pow(static_cast<double>(values[i]) - right[i], 2);
    squares += std::pow(static_cast<double>(right[i]), 2);
  }
  return std::sqrt(differences / squares);
}

double pyramidError(const patch::PatchGeometry& geometry, const Rtt& finest) {
  double worst = 0;
  formats::RadianceTransferTexture level = finest.texture;
  for (int factor = 2; level.width > 1; factor *= 2) {
    level = averaged(level);
    Options options = paperOptions();
    options.resolution = level.width;
    options.supersampling = 3 * factor;
    worst = std::max(worst, relativeError(level.values, makeRtt(geometry, options, [] {}).texture.values));
  }
  return worst;
}

void paper(benchmark::State& state, const std::string& name) {
  const patch::PatchGeometry geometry = patchOf(name);
  const Options options = paperOptions();
  double longest_edge = 1.0 / options.elements;
  const patch::PatchGeometry solved = withElements(geometry, longest_edge);
  const transport::PeriodicRayScene scene(solved.mesh, {solved.period_x, solved.period_y});
  const BareEmbree bare(scene.heldTriangles());
  const RayLists lists = raysOf(solved, scene, options);
  for (auto _ : state) {
    std::vector<double> ours;
    std::array<std::vector<double>, 5> rivals;
    Rtt made;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(secondsOf([&] { made = makeRtt(geometry, options, [] {}); }));
      rivals[0].push_back(bare.seconds<1>(lists, false));
      rivals[1].push_back(bare.seconds<8>(lists, false));
      rivals[2].push_back(bare.seconds<8>(lists, true));
      rivals[3].push_back(bare.seconds<16>(lists, false));
      rivals[4].push_back(bare.seconds<16>(lists, true));
    }
    if (made.figures.rays != lists.count()) {
      state.SkipWithError(("bake and bare Embree did not trace the same rays: " +
                           std::to_string(made.figures.rays) + " and " + std::to_string(lists.count()))
                              .c_str());
      return;
    }
    double best = 1e9;
    const std::array<const char*, 5> names = {"1", "8", "8_coherent", "16", "16_coherent"};
    for (std::size_t i = 0; i < rivals.size(); ++i) {
      best = std::min(best, median(rivals[i]));
      state.counters[std::string("embree_s_") + names[i]] = median(rivals[i]);
    }
    const std::array<double, 3> kinds = bare.secondsByKind(lists);
    state.counters["embree_direct_s"] = kinds[0];
    state.counters["embree_seeing_s"] = kinds[1];
    state.counters["embree_views_s"] = kinds[2];
    state.SetIterationTime(median(ours));
    state.counters["seconds"] = median(ours);
    state.counters["raw_ray_ratio"] = best / median(ours);
    state.counters["rays"] = static_cast<double>(made.figures.rays);
    state.counters["points"] = static_cast<double>(made.figures.surface_points);
    state.counters["tree_s"] = made.figures.tree_s;
    state.counters["direct_s"] = made.figures.direct_s;
    state.counters["seeing_s"] = made.figures.seeing_s;
    state.counters["solving_s"] = made.figures.solving_s;
    state.counters["views_s"] = made.figures.views_s;
    state.counters["pyramid_error"] = pyramidError(geometry, made);
  }
}
BENCHMARK_CAPTURE(paper, weave, "weave")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(paper, stucco, "stucco")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight::rtt

BENCHMARK_MAIN();
