// The transfer bake beside the ray tracer that it stands on: how much of bare Embree's ray rate is left once
// hemispheres are collected and coefficients are summed up, for vectors and for matrices; and what further
// bounces cost beside the shadow pass.
//
// raw_ray_ratio = (the bake's shadow rays/s) ÷ (the same rays through bare Embree in the same run), both on
// all cores. Bare Embree is given the rays in the same order and its best interface of those tried (single
// rays, packets of 8 and 16); bake and rival run in turn, and the ratio is that of the medians, as machines
// drift.
//
// million_vertices_ratio = (the bake's shadow rays/s at a million vertices) ÷ (the same at 35,000), of a
// rippled ball, with bounces; embree_million_ratio is the same of bare Embree, which has a tree 29 times as
// large to go through. peak_bytes_per_vertex is this process's peak over the million.
#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>
#include <sys/resource.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>

#include "formats/mesh_import.h"
#include "tests/support/rippled_ball.h"
#include "tools/simplify/simplify.h"
#include "tools/transfer/surface_points.h"
#include "tools/transfer/transfer.h"
#include "transport/camera.h"
#include "transport/directions.h"

namespace bakelight {
namespace {

using transport::vec3;
using Clock = std::chrono::steady_clock;

constexpr int kTriangles = 21596;  // about 10,800 vertices
constexpr int kDirections = 4096;
constexpr int kRounds = 5;

const formats::TriangleMesh& bunny() {
  static const formats::TriangleMesh mesh = [] {
    const char* folder = std::getenv("BAKELIGHT_DATA");
    const std::string path =
        std::string(folder != nullptr ? folder : BAKELIGHT_DATA_DIR) + "/models/bunny.obj";
    simplify::SimplifyOptions options;
    options.triangles = kTriangles;
    return simplify::simplify(formats::importMesh(path).mesh, options, path).mesh;
  }();
  return mesh;
}

// Embree without anything of ours around it.
class BareEmbree {
 public:
  explicit BareEmbree(const formats::TriangleMesh& mesh)
      : mesh_(mesh), directions_(transport::sphereDirections(kDirections)) {
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
    // The same tree as the bake's: the ratio is about what surrounds the tracer.
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene_);
    points_ = transfer::frontPoints(mesh, transfer::TransferOptions().bias);
  }
  ~BareEmbree() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  BareEmbree(const BareEmbree&) = delete;
  BareEmbree& operator=(const BareEmbree&) = delete;

  struct Traced {
    std::uint64_t rays = 0, blocked = 0;
    double rays_per_s = 0;
  };

  // `Packet` is RTCRay, RTCRay8 or RTCRay16. Of so many vertices side by side, every so often.
  template <class Packet, int kWidth>
  Traced trace(std::size_t taken = 1, std::size_t of = 1) const {
    std::atomic<std::uint64_t> rays{0}, blocked{0};
    const auto start = Clock::now();
    tbb::parallel_for(std::size_t{0}, mesh_.vertexCount() / of * taken, [&](std::size_t place) {
      const std::size_t vertex = place / taken * of + place % taken;
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      alignas(64) Packet packet{};
      alignas(64) int valid[kWidth];
      int filled = 0;
      std::uint64_t own_rays = 0, own_blocked = 0;
      const auto flush = [&] {
        for (int i = 0; i < kWidth; ++i) valid[i] = i < filled ? -1 : 0;
        if constexpr (kWidth == 1) rtcOccluded1(scene_, &context, reinterpret_cast<RTCRay*>(&packet));
        if constexpr (kWidth == 8) rtcOccluded8(valid, scene_, &context, reinterpret_cast<RTCRay8*>(&packet));
        if constexpr (kWidth == 16)
          rtcOccluded16(valid, scene_, &context, reinterpret_cast<RTCRay16*>(&packet));
        for (int i = 0; i < filled; ++i) own_blocked += lane(packet, 8, kWidth)[i] < 0 ? 1 : 0;
        own_rays += filled;
        filled = 0;
      };
      const formats::Float3& normal = mesh_.normals[vertex];
      const formats::Float3& origin = points_[vertex].origin;
      for (const auto& direction : directions_) {
        const formats::Float3 d = transport::float3(direction);
        if (normal[0] * d[0] + normal[1] * d[1] + normal[2] * d[2] <= 0) continue;
        // Field order of every Embree 3 ray type: org xyz, tnear, dir xyz, time, tfar, mask.
        for (int c = 0; c < 3; ++c) {
          lane(packet, c, kWidth)[filled] = origin[c];
          lane(packet, 4 + c, kWidth)[filled] = d[c];
        }
        lane(packet, 8, kWidth)[filled] = std::numeric_limits<float>::infinity();
        reinterpret_cast<unsigned*>(lane(packet, 9, kWidth))[filled] = ~0u;
        if (++filled == kWidth) flush();
      }
      if (filled > 0) flush();
      rays += own_rays;
      blocked += own_blocked;
    });
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return {rays, blocked, static_cast<double>(rays) / seconds};
  }

 private:
  template <class Packet>
  static float* lane(Packet& packet, int field, int width) {
    return reinterpret_cast<float*>(&packet) + static_cast<std::ptrdiff_t>(field) * width;
  }

  const formats::TriangleMesh& mesh_;
  std::vector<transport::Vec3> directions_;
  RTCDevice device_ = rtcNewDevice(nullptr);
  RTCScene scene_ = rtcNewScene(device_);
  std::vector<transfer::SurfacePoint> points_;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

struct TimedBake {
  transfer::Transfer transfer;
  double seconds = 0;
};

TimedBake timedBake(const formats::TriangleMesh& mesh, const transfer::TransferOptions& options) {
  stage::Progress silent(stage::ProgressStyle::kNone, "", 0, "");
  const std::vector<formats::Float3> albedo = {{0.8F, 0.8F, 0.8F}};
  const auto start = Clock::now();
  TimedBake timed{transfer::bakeTransfer(mesh, albedo, options, silent), 0};
  timed.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return timed;
}

// Arguments: order, and whether matrices (order² × order²) are baked too.
void shadowed(benchmark::State& state) {
  const formats::TriangleMesh& mesh = bunny();
  const BareEmbree bare(mesh);
  transfer::TransferOptions options;
  options.directions = kDirections;
  options.order = options.row_order = static_cast<int>(state.range(0));
  if (state.range(1) != 0) options.glossy = transfer::Glossy::kMatrices;

  for (auto _ : state) {
    std::vector<double> ours, singles, eights, sixteens, bake_s;
    TimedBake baked;
    BareEmbree::Traced traced;
    for (int round = 0; round < kRounds; ++round) {
      baked = timedBake(mesh, options);
      bake_s.push_back(baked.seconds);
      ours.push_back(static_cast<double>(baked.transfer.rays) / baked.seconds);
      singles.push_back(bare.trace<RTCRay, 1>().rays_per_s);
      eights.push_back(bare.trace<RTCRay8, 8>().rays_per_s);
      traced = bare.trace<RTCRay16, 16>();
      sixteens.push_back(traced.rays_per_s);
    }
    if (traced.rays != baked.transfer.rays || traced.blocked != baked.transfer.blocked_rays) {
      state.SkipWithError("bake and bare Embree did not trace the same rays");
      return;
    }
    const double rival = std::max({median(singles), median(eights), median(sixteens)});
    state.SetIterationTime(median(bake_s));
    state.counters["raw_ray_ratio"] = median(ours) / rival;
    state.counters["rays"] = static_cast<double>(baked.transfer.rays);
    state.counters["blocked_share"] =
        static_cast<double>(baked.transfer.blocked_rays) / static_cast<double>(baked.transfer.rays);
    state.counters["bake_rays_per_s"] = median(ours);
    state.counters["embree_rays_per_s_1"] = median(singles);
    state.counters["embree_rays_per_s_8"] = median(eights);
    state.counters["embree_rays_per_s_16"] = median(sixteens);
    state.counters["vertices"] = static_cast<double>(mesh.vertexCount());
    state.counters["quadrature_error"] = baked.transfer.quadrature_error;
  }
}
BENCHMARK(shadowed)
    ->Name("shadowed_vectors")
    ->Args({5, 0})
    ->ArgNames({"order", "matrices"})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(shadowed)
    ->Name("shadowed_matrices")
    ->Args({5, 1})
    ->ArgNames({"order", "matrices"})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

// bounces_vs_shadow = (bake with so many further bounces − bake with shadows only) ÷ the latter. `matrices`:
// both with matrices. The bounces of the paper took as long as its shadow pass (8 and 17 minutes).
void furtherBounces(benchmark::State& state) {
  const formats::TriangleMesh& mesh = bunny();
  transfer::TransferOptions shadow;
  shadow.directions = kDirections;
  shadow.order = shadow.row_order = 5;
  if (state.range(1) != 0) shadow.glossy = transfer::Glossy::kMatrices;
  transfer::TransferOptions bounced = shadow;
  bounced.transport = transfer::Transport::kInterreflected;
  bounced.interreflection.bounces = static_cast<int>(state.range(0));
  for (auto _ : state) {
    std::vector<double> shadow_s, bounced_s;
    TimedBake last;
    for (int round = 0; round < kRounds; ++round) {
      shadow_s.push_back(timedBake(mesh, shadow).seconds);
      last = timedBake(mesh, bounced);
      bounced_s.push_back(last.seconds);
    }
    const auto& energy = last.transfer.interreflection.added_energy;
    if (static_cast<int>(energy.size()) != state.range(0)) {
      state.SkipWithError("other bounces than asked for");
      return;
    }
    state.SetIterationTime(median(bounced_s));
    state.counters["bounces_vs_shadow"] = median(bounced_s) / median(shadow_s) - 1;
    state.counters["shadow_ms"] = 1000 * median(shadow_s);
    state.counters["added_energy_first"] = energy.front();
    state.counters["added_energy_last"] = energy.back();
  }
}
BENCHMARK(furtherBounces)
    ->Name("further_bounces")
    ->Args({3, 0})
    ->Args({3, 1})
    ->ArgNames({"bounces", "matrices"})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

formats::TriangleMesh smoothBall(std::size_t triangles) {
  formats::TriangleMesh mesh = tests::rippledBall(triangles);
  std::vector<transport::Vec3> sums(mesh.vertexCount(), transport::Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const transport::Vec3 origin = vec3(mesh.positions[a]);
    const transport::Vec3 area = (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin);
    for (const std::uint32_t v : {a, b, c}) sums[v] += area;
  }
  for (const transport::Vec3& sum : sums) mesh.normals.push_back(transport::float3(sum.normalized()));
  return mesh;
}

void millionVertices(benchmark::State& state) {
  constexpr std::size_t kTaken = 64, kOf = 64 * 64;
  transfer::TransferOptions options;
  options.directions = static_cast<int>(state.range(0));
  options.transport = transfer::Transport::kInterreflected;
  for (auto _ : state) {
    std::vector<double> small_rays_per_s, small_embree;
    {
      const formats::TriangleMesh mesh = smoothBall(70'000);
      const BareEmbree bare(mesh);
      for (int round = 0; round < 3; ++round) {
        const transfer::Transfer baked = timedBake(mesh, options).transfer;
        small_rays_per_s.push_back(static_cast<double>(baked.rays) / baked.shadow_s);
        small_embree.push_back(bare.trace<RTCRay16, 16>().rays_per_s);
      }
    }
    const formats::TriangleMesh mesh = smoothBall(2'000'000);
    const TimedBake large = timedBake(mesh, options);
    const transfer::Transfer& baked = large.transfer;
    struct rusage usage {};
    getrusage(RUSAGE_SELF, &usage);
    const auto vertices = static_cast<double>(mesh.vertexCount());
    const double rays_per_s = static_cast<double>(baked.rays) / baked.shadow_s;
    const BareEmbree bare(mesh);
    std::vector<double> embree;
    for (int round = 0; round < 3; ++round)
      embree.push_back(bare.trace<RTCRay16, 16>(kTaken, kOf).rays_per_s);
    state.SetIterationTime(large.seconds);
    state.counters["million_vertices_ratio"] = rays_per_s / median(small_rays_per_s);
    state.counters["embree_million_ratio"] = median(embree) / median(small_embree);
    state.counters["peak_bytes_per_vertex"] = 1024.0 * static_cast<double>(usage.ru_maxrss) / vertices;
    state.counters["rays_per_s"] = rays_per_s;
    state.counters["setup_s"] =
        large.seconds - baked.shadow_s - baked.interreflection_s;  // tree, sides, the choice of storage
    state.counters["interreflection_s"] = baked.interreflection_s;
    state.counters["shares_per_vertex"] = static_cast<double>(baked.form_factors) / vertices;
    state.counters["exact_shares"] = baked.exact_shares ? 1 : 0;
  }
}
BENCHMARK(millionVertices)
    ->Name("million_vertices")
    ->Arg(kDirections)
    ->ArgName("directions")
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight

BENCHMARK_MAIN();
