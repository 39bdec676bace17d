#include "tools/reference/pictures.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tools/reference/coverage.h"
#include "transport/vertex_fit.h"

namespace bakelight::reference {
namespace {

using transport::float3;
using transport::StratifiedBatch;
using transport::vec3;

constexpr int kPixelDimension = 0;
constexpr int kBackgroundBatches = 4;

formats::Image emptyImage(const View& view) {
  return {view.width_px, view.height_px, {"R", "G", "B", "A", "variance.R", "variance.G", "variance.B"}};
}

void setPixel(formats::Image& image, std::size_t pixel, const Rgb& mean, double alpha, const Rgb& variance) {
  float* const values = &image.values[pixel * image.channelCount()];
  for (int c = 0; c < 3; ++c) {
    values[c] = static_cast<float>(mean[c]);
    values[4 + c] = static_cast<float>(variance[c]);
  }
  values[3] = static_cast<float>(alpha);
}

double ratioOfRoots(double variance, double square) {
  return variance > 0 ? std::sqrt(variance / square) : 0;
}

class PixelTracer {
 public:
  PixelTracer(const Scene& scene, const PathTracer& tracer, const View& view, std::uint64_t seed)
      : scene_(scene),
        tracer_(tracer),
        view_(view),
        seed_(seed),
        eye_(view.camera.eye()),
        covered_(possiblyCovered(scene.rayMesh(), view.camera, view.width_px, view.height_px)),
        pixels_(covered_.size()) {
    if (view.ground) covered_.assign(covered_.size(), 1);
  }

  std::size_t pixelCount() const { return pixels_.size(); }

  TraceCounts trace(std::size_t pixel, int first_batch, int end_batch) {
    TraceCounts counts;
    // The background alone needs no more than its box filter.
    if (covered_[pixel] == 0) end_batch = std::min(end_batch, kBackgroundBatches);
    for (int batch = first_batch; batch < end_batch; ++batch)
      traceBatch(pixel, StratifiedBatch(seed_, pixel, static_cast<std::uint64_t>(batch)), counts);
    return counts;
  }

  double relativeError() const {
    double variance = 0, square = 0;
    for (const Pixel& pixel : pixels_) {
      if (!pixel.sees_object) continue;
      variance += pixel.radiance.luminanceVariance();
      square += pixel.radiance.luminance() * pixel.radiance.luminance();
    }
    return ratioOfRoots(variance, square);
  }

  Picture picture() const {
    Picture picture{emptyImage(view_), {}, 0};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const Pixel& pixel = pixels_[i];
      setPixel(picture.image, i, pixel.radiance.mean(),
               pixel.alpha / (pixel.radiance.batches() * StratifiedBatch::kSize), pixel.radiance.variance());
      picture.object_pixels += pixel.sees_object ? 1 : 0;
    }
    return picture;
  }

 private:
  struct Pixel {
    BatchMeans radiance;
    double alpha = 0;  // summed over samples
    bool sees_object = false;
  };

  void traceBatch(std::size_t index, const StratifiedBatch& batch, TraceCounts& counts) {
    constexpr std::size_t kSize = StratifiedBatch::kSize;
    thread_local transport::RayBundle bundle(kSize);
    thread_local transport::HitBundle hits(kSize);
    std::array<Vec3, kSize> directions;
    const auto width = static_cast<std::size_t>(view_.width_px);
    const std::size_t column = index % width, row = index / width;
    for (std::size_t s = 0; s < kSize; ++s) {
      const auto [x, y] = batch.pair(static_cast<int>(s), kPixelDimension);
      directions[s] = view_.camera.directionThrough(
          static_cast<double>(column) + x, static_cast<double>(row) + y, view_.width_px, view_.height_px);
      bundle.set(s, float3(directions[s]));
    }
    if (covered_[index] != 0) {
      scene_.rays().nearestHits(float3(eye_), bundle, 0, kSize, hits);
      counts.rays += kSize;
    } else {
      std::fill(hits.blocked.begin(), hits.blocked.end(), std::uint8_t{0});
    }

    Pixel& pixel = pixels_[index];
    Rgb sum = Rgb::Zero();
    for (std::size_t s = 0; s < kSize; ++s) {
      if (hits.blocked[s] == 0) {
        const SampleOfBatch sample{batch, static_cast<int>(s)};
        const double opacity = addGround(pixel, directions[s], sample, sum, counts);
        const formats::Float4 seen = view_.backdrop(directions[s]);
        sum += (1 - opacity) * Rgb(seen[0], seen[1], seen[2]);
        pixel.alpha += (1 - opacity) * static_cast<double>(seen[3]);
        continue;
      }
      pixel.alpha += 1;
      if (scene_.isEmitter(hits.triangle[s])) {
        sum += scene_.emitters().radiance(scene_.emitterTriangle(hits.triangle[s]));
        continue;
      }
      pixel.sees_object = true;
      const transport::Hit hit{true,      hits.distance[s], hits.triangle[s],
                               hits.u[s], hits.v[s],        hits.back_face[s] != 0};
      sum += tracer_.exitRadiance(scene_.pointAt(hit), -directions[s], {batch, static_cast<int>(s)}, counts);
    }
    pixel.radiance.add(sum / kSize);
  }

  // Its opacity there.
  double addGround(Pixel& pixel, const Vec3& direction, const SampleOfBatch& sample, Rgb& sum,
                   TraceCounts& counts) const {
    if (!view_.ground) return 0;
    const auto seen = view_.ground->seen(eye_, direction, scene_.diffuseMaterial());
    if (!seen) return 0;
    pixel.alpha += seen->opacity;
    pixel.sees_object = true;
    sum += seen->opacity * tracer_.exitRadiance(seen->point, -direction, sample, counts);
    return seen->opacity;
  }

  const Scene& scene_;
  const PathTracer& tracer_;
  const View& view_;
  std::uint64_t seed_;
  Vec3 eye_;
  std::vector<std::uint8_t> covered_;
  std::vector<Pixel> pixels_;
};

// A pixel as a sum of vertices and what does not depend on them.
struct InterpolatedPixel {
  std::vector<std::pair<std::uint32_t, double>> weights;  // by vertex, each once
  Rgb constant = Rgb::Zero();                             // background and emitters
  double alpha = 0;
};

InterpolatedPixel interpolate(const Scene& scene, const View& view, int x, int y) {
  constexpr double kShare = 1.0 / (kInterpolatedSubsamples * kInterpolatedSubsamples);
  const Vec3 eye = view.camera.eye();
  InterpolatedPixel pixel;
  const auto addVertex = [&](std::uint32_t vertex, double weight) {
    const auto found = std::find_if(pixel.weights.begin(), pixel.weights.end(),
                                    [&](const auto& entry) { return entry.first == vertex; });
    if (found == pixel.weights.end())
      pixel.weights.emplace_back(vertex, weight);
    else
      found->second += weight;
  };
  for (int j = 0; j < kInterpolatedSubsamples; ++j)
    for (int i = 0; i < kInterpolatedSubsamples; ++i) {
      const Vec3 direction = view.camera.directionThrough(x + (i + 0.5) / kInterpolatedSubsamples,
                                                          y + (j + 0.5) / kInterpolatedSubsamples,
                                                          view.width_px, view.height_px);
      const transport::Hit hit = scene.rays().nearestHit(eye, direction);
      const formats::Float4 behind = hit.valid ? formats::Float4{0, 0, 0, 1} : view.backdrop(direction);
      pixel.alpha += kShare * behind[3];
      pixel.constant += kShare * Rgb(behind[0], behind[1], behind[2]);
      if (!hit.valid) continue;
      if (scene.isEmitter(hit.triangle)) {
        pixel.constant += kShare * scene.emitters().radiance(scene.emitterTriangle(hit.triangle));
        continue;
      }
      const formats::Triangle& corners = scene.mesh().triangles[hit.triangle];
      addVertex(corners[0], kShare * (1.0 - hit.u - hit.v));
      addVertex(corners[1], kShare * hit.u);
      addVertex(corners[2], kShare * hit.v);
    }
  return pixel;
}

std::vector<InterpolatedPixel> interpolatedPixels(const Scene& scene, const View& view) {
  std::vector<InterpolatedPixel> pixels(static_cast<std::size_t>(view.width_px) * view.height_px);
  tbb::parallel_for(0, view.height_px, [&](int y) {
    for (int x = 0; x < view.width_px; ++x)
      pixels[static_cast<std::size_t>(y) * view.width_px + x] = interpolate(scene, view, x, y);
  });
  return pixels;
}
std::uint64_t cameraRays(const std::vector<InterpolatedPixel>& pixels) {
  return pixels.size() * kInterpolatedSubsamples * kInterpolatedSubsamples;
}
// An eye at the point itself looks along the normal, as the player's does.
Vec3 towards(const Vec3& eye, const Vec3& position, const Vec3& normal) {
  const Vec3 offset = eye - position;
  return offset.norm() > 0 ? Vec3(offset.normalized()) : normal;
}

class VertexTracer {
 public:
  VertexTracer(const Scene& scene, const PathTracer& tracer, const View& view, std::uint64_t seed)
      : scene_(scene),
        tracer_(tracer),
        view_(view),
        seed_(seed),
        eye_(view.camera.eye()),
        pixels_(interpolatedPixels(scene, view)),
        vertices_(scene.mesh().vertexCount()),
        squared_weights_(scene.mesh().vertexCount(), 0.0) {
    for (const InterpolatedPixel& pixel : pixels_)
      for (const auto& [vertex, weight] : pixel.weights) squared_weights_[vertex] += weight * weight;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v)
      if (squared_weights_[v] > 0) seen_.push_back(v);
  }

  std::size_t seenCount() const { return seen_.size(); }
  std::uint64_t cameraRays() const { return reference::cameraRays(pixels_); }

  TraceCounts trace(std::size_t place, int first_batch, int end_batch) {
    const std::uint32_t vertex = seen_[place];
    const ShadingPoint point = scene_.pointAtVertex(vertex);
    const Vec3 outgoing = towards(eye_, vec3(scene_.mesh().positions[vertex]), point.normal);
    TraceCounts counts;
    for (int number = first_batch; number < end_batch; ++number) {
      const StratifiedBatch batch(seed_, vertex, static_cast<std::uint64_t>(number));
      Rgb sum = Rgb::Zero();
      for (int s = 0; s < StratifiedBatch::kSize; ++s)
        sum += tracer_.exitRadiance(point, outgoing, {batch, s}, counts);
      vertices_[vertex].add(sum / StratifiedBatch::kSize);
    }
    return counts;
  }

  double relativeError() const {
    double variance = 0, square = 0;
    for (const std::uint32_t vertex : seen_)
      variance += squared_weights_[vertex] * vertices_[vertex].luminanceVariance();
    for (const InterpolatedPixel& pixel : pixels_) {
      if (pixel.weights.empty()) continue;
      double luminance = transport::luminance(float3(pixel.constant.matrix()));
      for (const auto& [vertex, weight] : pixel.weights) luminance += weight * vertices_[vertex].luminance();
      square += luminance * luminance;
    }
    return ratioOfRoots(variance, square);
  }

  Picture picture() const {
    Picture picture{emptyImage(view_), {}, 0};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const InterpolatedPixel& pixel = pixels_[i];
      Rgb mean = pixel.constant, variance = Rgb::Zero();
      for (const auto& [vertex, weight] : pixel.weights) {
        mean += weight * vertices_[vertex].mean();
        variance += weight * weight * vertices_[vertex].variance();
      }
      setPixel(picture.image, i, mean, pixel.alpha, variance);
      picture.object_pixels += pixel.weights.empty() ? 0 : 1;
    }
    return picture;
  }

 private:
  const Scene& scene_;
  const PathTracer& tracer_;
  const View& view_;
  std::uint64_t seed_;
  Vec3 eye_;
  std::vector<InterpolatedPixel> pixels_;
  std::vector<BatchMeans> vertices_;
  std::vector<double> squared_weights_;  // of each vertex, over all pixels
  std::vector<std::uint32_t> seen_;      // vertices with a weight
};

// Values at vertices fitted to paths from all over the triangles.
class TriangleTracer {
 public:
  TriangleTracer(const Scene& scene, const PathTracer& tracer, const View& view, std::uint64_t seed)
      : scene_(scene),
        tracer_(tracer),
        view_(view),
        seed_(seed),
        eye_(view.camera.eye()),
        pixels_(interpolatedPixels(scene, view)),
        triangles_(nearSeenVertices()),
        sums_(triangles_.size()) {}

  std::size_t triangleCount() const { return triangles_.size(); }
  std::uint64_t cameraRays() const { return reference::cameraRays(pixels_); }

  TraceCounts trace(std::size_t place, int first_batch, int end_batch) {
    TraceCounts counts;
    for (int number = first_batch; number < end_batch; ++number) traceBatch(place, number, counts);
    if (place == 0) batches_ = end_batch;
    return counts;
  }

  double relativeError() {
    solve();
    double variance = 0, square = 0;
    for (const InterpolatedPixel& pixel : pixels_) {
      if (pixel.weights.empty()) continue;
      const Shown shown = show(pixel);
      variance += shown.luminance_variance;
      const double luminance = transport::luminance(float3(shown.mean.matrix()));
      square += luminance * luminance;
    }
    return ratioOfRoots(variance, square);
  }

  Picture picture() const {
    Picture picture{emptyImage(view_), {}, 0};
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      const Shown shown = show(pixels_[i]);
      setPixel(picture.image, i, shown.mean, pixels_[i].alpha, shown.variance);
      picture.object_pixels += pixels_[i].weights.empty() ? 0 : 1;
    }
    return picture;
  }

 private:
  static constexpr std::size_t kColumns = std::size_t{3} * kFittedGroups;  // groups × colours
  // Σ over the batches of a group of what the samples of one say: of each corner, in each column.
  using Sums = std::array<std::array<double, kColumns>, 3>;

  std::vector<std::uint32_t> nearSeenVertices() const {
    const formats::TriangleMesh& mesh = scene_.mesh();
    std::vector<std::uint8_t> near(mesh.vertexCount(), 0);
    for (const InterpolatedPixel& pixel : pixels_)
      for (const auto& [vertex, weight] : pixel.weights) near[vertex] = 1;
    std::vector<std::uint32_t> found;
    for (int ring = 0; ring < kFittedRings; ++ring) {
      found.clear();
      for (std::uint32_t t = 0; t < mesh.triangleCount(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        if (near[a] + near[b] + near[c] > 0) found.push_back(t);
      }
      for (const std::uint32_t t : found)
        for (const std::uint32_t v : mesh.triangles[t]) near[v] = 1;
    }
    return found;
  }

  void traceBatch(std::size_t place, int number, TraceCounts& counts) {
    constexpr int kSize = StratifiedBatch::kSize;
    const std::uint32_t triangle = triangles_[place];
    const StratifiedBatch batch(seed_, triangle, static_cast<std::uint64_t>(number));
    std::array<Vec3, kSize> weights;
    std::array<Rgb, kSize> radiance;
    Vec3 mean_weights = Vec3::Zero();
    Rgb mean = Rgb::Zero();
    for (int s = 0; s < kSize; ++s) {
      auto [u, v] = batch.pair(s, kPixelDimension);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      weights[s] = {1 - u - v, u, v};
      const ShadingPoint point =
          scene_.pointAt({true, 0, triangle, static_cast<float>(u), static_cast<float>(v), false});
      radiance[s] =
          tracer_.exitRadiance(point, towards(eye_, point.position, point.normal), {batch, s}, counts);
      mean_weights += weights[s] / kSize;
      mean += radiance[s] / kSize;
    }
    // ∫ hat · radiance as (∫ hat) · mean + covariance: where the places happen to lie makes no noise of the mean.
    for (int corner = 0; corner < 3; ++corner) {
      Rgb share = mean / 3;
      for (int s = 0; s < kSize; ++s)
        share += (weights[s][corner] - mean_weights[corner]) * (radiance[s] - mean) / kSize;
      for (int c = 0; c < 3; ++c)
        sums_[place][corner][3 * static_cast<std::size_t>(number % kFittedGroups) + c] += share[c];
    }
  }

  int batchesOf(int group) const {
    return batches_ / kFittedGroups + (group < batches_ % kFittedGroups ? 1 : 0);
  }

  void solve() {
    // Definite where triangles have no area; it moves no picture.
    constexpr double kSmoothness = 1e-4;
    const formats::TriangleMesh& mesh = scene_.mesh();
    transport::VertexFit fit(mesh, kColumns, kSmoothness);
    for (std::size_t place = 0; place < triangles_.size(); ++place) {
      const auto& [a, b, c] = mesh.triangles[triangles_[place]];
      const Vec3 origin = vec3(mesh.positions[a]);
      const double area =
          (vec3(mesh.positions[b]) - origin).cross(vec3(mesh.positions[c]) - origin).norm() / 2;
      const auto own = static_cast<float>(area / 6), other = static_cast<float>(area / 12);
      transport::VertexFit::Element element{{own, other, other, own, other, own}, {}};
      for (int corner = 0; corner < 3; ++corner)
        for (std::size_t column = 0; column < kColumns; ++column) {
          const int count = batchesOf(static_cast<int>(column / 3));
          element.right.push_back(count > 0 ? static_cast<float>(area * sums_[place][corner][column] / count)
                                            : 0.0F);
        }
      fit.add(triangles_[place], element);
    }
    values_ = fit.solve().rows;
    first_copy_.clear();
    for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v) first_copy_.push_back(fit.firstCopy(v));
  }

  struct Shown {
    Rgb mean, variance;
    double luminance_variance = 0;
  };
  Shown show(const InterpolatedPixel& pixel) const {
    BatchMeans spread;
    Rgb mean = Rgb::Zero();
    const int groups = std::min(batches_, kFittedGroups);
    for (int group = 0; group < groups; ++group) {
      Rgb shown = pixel.constant;
      for (const auto& [vertex, weight] : pixel.weights)
        for (int c = 0; c < 3; ++c)
          shown[c] +=
              weight * values_[first_copy_[vertex] * kColumns + 3 * static_cast<std::size_t>(group) + c];
      spread.add(shown);
      mean += shown * batchesOf(group) / batches_;
    }
    return {mean, spread.variance(), spread.luminanceVariance()};
  }

  const Scene& scene_;
  const PathTracer& tracer_;
  const View& view_;
  std::uint64_t seed_;
  Vec3 eye_;
  std::vector<InterpolatedPixel> pixels_;
  std::vector<std::uint32_t> triangles_;
  std::vector<Sums> sums_;  // of triangles_
  int batches_ = 0;         // of each
  std::vector<float> values_;
  std::vector<std::uint32_t> first_copy_;
};

template <class Tracer>
Picture pictureBy(Tracer& tracer, std::size_t elements, const Effort& effort, stage::ProgressStyle progress) {
  const RoundsReport report = runRounds(
      elements, effort,
      [&](std::size_t element, int first, int end) { return tracer.trace(element, first, end); },
      [&] { return tracer.relativeError(); }, progress);
  Picture picture = tracer.picture();
  picture.report = report;
  return picture;
}

}  // namespace

Picture tracePixels(const Scene& scene, const PathTracer& tracer, const View& view, const Effort& effort,
                    std::uint64_t seed, stage::ProgressStyle progress) {
  PixelTracer pixels(scene, tracer, view, seed);
  return pictureBy(pixels, pixels.pixelCount(), effort, progress);
}

Picture traceVertices(const Scene& scene, const PathTracer& tracer, const View& view, const Effort& effort,
                      std::uint64_t seed, stage::ProgressStyle progress) {
  VertexTracer vertices(scene, tracer, view, seed);
  Picture picture = pictureBy(vertices, vertices.seenCount(), effort, progress);
  picture.report.counts.rays += vertices.cameraRays();
  return picture;
}

Picture traceTriangles(const Scene& scene, const PathTracer& tracer, const View& view, const Effort& effort,
                       std::uint64_t seed, stage::ProgressStyle progress) {
  TriangleTracer triangles(scene, tracer, view, seed);
  Picture picture = pictureBy(triangles, triangles.triangleCount(), effort, progress);
  picture.report.counts.rays += triangles.cameraRays();
  return picture;
}

}  // namespace bakelight::reference
