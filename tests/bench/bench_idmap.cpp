// The id map of the Stanford bunny, and bare FLANN for the same searches: what normal shooting costs beside what it
// cannot do without; and whether it finds what an exhaustive search finds.
//
//   bench_idmap [Google Benchmark flags]
//
// flann_ratio = (seconds of the id map, maps read from their file and gutters filled) ÷ (seconds of bare FLANN: its
// tree built and asked for the k nearest of each covered texel), both on all cores; medians of runs in turn. Bare FLANN
// is given the texels in the better of two orders, row by row and along a Morton curve.
#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <flann/flann.hpp>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "formats/mesh_import.h"
#include "tests/support/temporary_folder.h"
#include "tools/atlas/make_atlas.h"
#include "tools/atlas/maps/geometry_maps.h"
#include "tools/idmap/idmap.h"
#include "tools/mesomesh/retile/retile.h"
#include "tools/simplify/simplify.h"
#include "transport/morton.h"
#include "transport/random.h"
#include "transport/vector_types.h"

namespace bakelight::idmap {
namespace {

using transport::Vec3;
using transport::vec3;
using Clock = std::chrono::steady_clock;

constexpr int kResolution = 2048, kBorder = 2, kRounds = 5, kTriangles = 20000;
constexpr std::size_t kNeighbors = 20, kBatch = 256, kSampled = 10000;

double secondsOf(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

std::string bunnyPath() {
  const char* folder = std::getenv("BAKELIGHT_DATA");
  return std::string(folder != nullptr ? folder : BAKELIGHT_DATA_DIR) + "/models/bunny.obj";
}

formats::TriangleMesh simplified() {
  simplify::SimplifyOptions options;
  options.triangles = kTriangles;
  return simplify::simplify(formats::importMesh(bunnyPath()).mesh, options, bunnyPath()).mesh;
}

// Of the bunny as it was given.
formats::TriangleMesh mesoMesh() {
  mesomesh::RetileOptions options;
  options.vertices = 960'000;
  return mesomesh::retile(formats::importMesh(bunnyPath()).mesh, options, bunnyPath()).mesh;
}

struct Query {
  Float3 position, normal;
  int x, y;
};

// Seconds of FLANN for the k nearest of all queries in this order.
double bareFlann(const formats::TriangleMesh& meso, std::span<const Query> queries) {
  std::vector<float> coordinates, points;
  for (const Float3& p : meso.positions) coordinates.insert(coordinates.end(), p.begin(), p.end());
  for (const Query& q : queries) points.insert(points.end(), q.position.begin(), q.position.end());
  return secondsOf([&] {
    flann::Index<flann::L2_3D<float>> tree(flann::Matrix<float>(coordinates.data(), meso.vertexCount(), 3),
                                           flann::KDTreeSingleIndexParams(10));
    tree.buildIndex();
    tbb::parallel_for(std::size_t{0}, (queries.size() + kBatch - 1) / kBatch, [&](std::size_t batch) {
      const std::size_t first = batch * kBatch, count = std::min(kBatch, queries.size() - first);
      std::vector<std::size_t> indices(kNeighbors * count);
      std::vector<float> distances(kNeighbors * count);
      flann::Matrix<std::size_t> index_rows(indices.data(), count, kNeighbors);
      flann::Matrix<float> distance_rows(distances.data(), count, kNeighbors);
      tree.knnSearch(flann::Matrix<float>(&points[3 * first], count, 3), index_rows, distance_rows,
                     kNeighbors, flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
      benchmark::DoNotOptimize(indices.data());
    });
  });
}

// The paper's rule, by looking at every vertex.
std::optional<std::uint32_t> exhaustive(const formats::TriangleMesh& meso, const Query& query) {
  std::vector<std::pair<double, std::uint32_t>> all;
  for (std::uint32_t v = 0; v < meso.vertexCount(); ++v)
    all.emplace_back((vec3(meso.positions[v]) - vec3(query.position)).squaredNorm(), v);
  std::partial_sort(all.begin(), all.begin() + kNeighbors, all.end());
  std::optional<std::uint32_t> best;
  double least = 0;
  for (std::size_t i = 0; i < kNeighbors; ++i) {
    const std::uint32_t v = all[i].second;
    const Vec3 way = vec3(meso.positions[v]) - vec3(query.position), normal = vec3(query.normal);
    if (normal.dot(vec3(meso.normals[v])) <= 0) continue;
    const double line = (way - way.dot(normal) * normal).squaredNorm();
    if (!best || line < least) best = v, least = line;
  }
  return best;
}

double lineDistance(const formats::TriangleMesh& meso, const Query& query, std::uint32_t v) {
  const Vec3 way = vec3(meso.positions[v]) - vec3(query.position), normal = vec3(query.normal);
  return (way - way.dot(normal) * normal).norm();
}

void bunny(benchmark::State& state) {
  const formats::TriangleMesh meso = mesoMesh();
  const formats::TriangleMesh coarse = simplified();
  atlas::AtlasOptions options;
  options.resolution = kResolution;
  const atlas::Atlas made = atlas::makeAtlas(coarse, {}, options, "bunny").atlas;
  const formats::Image maps = atlas::geometryMaps(made, {kResolution, kBorder}, "bunny");
  const tests::TemporaryFolder folder;
  const auto file = folder.path() / "maps.exr";
  formats::writeExr(file, maps, formats::ExrPrecision::kFloat);

  std::vector<Query> by_rows;
  const auto channel = [&](const char* name) { return static_cast<std::size_t>(maps.channelIndex(name)); };
  const std::size_t coverage = channel("coverage"), position = channel("position.X"),
                    normal = channel("normal.X");
  for (int y = 0; y < kResolution; ++y)
    for (int x = 0; x < kResolution; ++x)
      if (const float* t = maps.texel(x, y); t[coverage] != 0)
        by_rows.push_back({{t[position], t[position + 1], t[position + 2]},
                           {t[normal], t[normal + 1], t[normal + 2]},
                           x,
                           y});
  std::vector<Query> along_curve = by_rows;
  std::sort(along_curve.begin(), along_curve.end(), [](const Query& a, const Query& b) {
    const auto code = [](const Query& q) {
      return transport::mortonCode(static_cast<std::uint16_t>(q.x), static_cast<std::uint16_t>(q.y));
    };
    return code(a) < code(b);
  });

  const std::vector<Float2> patch(meso.vertexCount(), Float2{0, 0});
  const MesoIndex index{{meso, {}}, patch};
  for (auto _ : state) {
    std::vector<double> ours, rows, curve;
    IdMap map;
    for (int round = 0; round < kRounds; ++round) {
      ours.push_back(secondsOf([&] { map = makeIdMap(index, file, {}, [](std::size_t) {}); }));
      rows.push_back(bareFlann(meso, by_rows));
      curve.push_back(bareFlann(meso, along_curve));
    }
    std::int64_t same = 0, tied = 0, wrong = 0;
    std::vector<std::size_t> sampled(kSampled);
    for (std::size_t i = 0; i < kSampled; ++i) sampled[i] = transport::scrambled(i) % by_rows.size();
    std::vector<std::uint8_t> verdict(kSampled);
    tbb::parallel_for(std::size_t{0}, kSampled, [&](std::size_t i) {
      const Query& query = by_rows[sampled[i]];
      const std::uint32_t found = map.image.texel(query.x, query.y)[3];
      const std::optional<std::uint32_t> right = exhaustive(meso, query);
      if (right == found) return;
      verdict[i] = right && lineDistance(meso, query, *right) == lineDistance(meso, query, found) ? 1 : 2;
    });
    for (const std::uint8_t v : verdict) ++(v == 0 ? same : v == 1 ? tied : wrong);
    struct rusage usage {};
    getrusage(RUSAGE_SELF, &usage);
    state.SetIterationTime(median(ours));
    state.counters["flann_ratio"] = median(ours) / std::min(median(rows), median(curve));
    state.counters["flann_rows_seconds"] = median(rows);
    state.counters["flann_curve_seconds"] = median(curve);
    state.counters["covered_texels"] = static_cast<double>(map.covered);
    state.counters["meso_vertices"] = static_cast<double>(meso.vertexCount());
    state.counters["sampled"] = kSampled;
    state.counters["ties"] = static_cast<double>(tied);
    state.counters["differences"] = static_cast<double>(wrong);
    state.counters["widened"] = static_cast<double>(map.figures.widened);
    state.counters["other_sheets"] = static_cast<double>(map.figures.other_sheets);
    state.counters["peak_bytes"] = 1024.0 * static_cast<double>(usage.ru_maxrss);
    if (map.covered != static_cast<std::int64_t>(by_rows.size()))
      state.SkipWithError("the map and bare FLANN did not look for the same texels");
  }
}
BENCHMARK(bunny)->Name("bunny")->Iterations(1)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bakelight::idmap

BENCHMARK_MAIN();
