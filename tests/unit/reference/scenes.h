// Surfaces, lights and estimates for the path tracer's tests.
#pragma once

#include <cmath>

#include "formats/light_rig.h"
#include "tests/support/shapes.h"
#include "tools/reference/reference.h"

namespace bakelight::tests {

using reference::Rgb;

inline reference::Surface surfaceOf(
    const TriangleMesh& mesh, float albedo, const formats::Reflection& reflection = formats::Lambert(),
    reference::ReflectionModel model = reference::ReflectionModel::kPhysical) {
  reference::Surface surface{mesh, {}, model};
  surface.material.reflections = {reflection};
  surface.material.albedo = {albedo, albedo, albedo};
  return surface;
}

inline formats::LightRig diskRig(double half_angle_deg, float radiance, const Float3& direction = {0, 1, 0}) {
  formats::LightRig rig;
  rig.distant.emplace_back(formats::DiskLight{direction, half_angle_deg, {radiance, radiance, radiance}});
  return rig;
}
inline formats::LightRig uniformRig(float radiance = 1) {
  return diskRig(180, radiance);
}

// Every triangle with vertices and a normal of its own.
inline TriangleMesh flatShaded(const TriangleMesh& mesh) {
  TriangleMesh flat;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 corner = vec3(mesh.positions[a]);
    const Vec3 normal =
        (vec3(mesh.positions[b]) - corner).cross(vec3(mesh.positions[c]) - corner).normalized();
    const auto first = static_cast<std::uint32_t>(flat.vertexCount());
    for (const auto v : {a, b, c}) {
      flat.positions.push_back(mesh.positions[v]);
      flat.normals.push_back(float3(normal));
    }
    flat.triangles.push_back({first, first + 1, first + 2});
  }
  return flat;
}

// A horizontal square around the origin, facing +Y.
inline TriangleMesh floorSquare(float half_width) {
  TriangleMesh mesh;
  const float w = half_width;
  mesh.positions = {{-w, 0, w}, {w, 0, w}, {w, 0, -w}, {-w, 0, -w}};
  mesh.normals.assign(4, {0, 1, 0});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

inline reference::Scene sceneOf(const reference::Surface& surface, const formats::LightRig& rig,
                                const formats::FrameSettings& frame = {}) {
  return {surface, rig, frame, transport::boundingSphere(surface.mesh)};
}

// Exit radiance of a point from so many batches of 16 samples.
inline reference::BatchMeans estimate(const reference::Scene& scene, const reference::PathOptions& options,
                                      const reference::ShadingPoint& point, const Vec3& outgoing, int batches,
                                      std::uint64_t element = 0) {
  const reference::PathTracer tracer(scene, options);
  reference::BatchMeans means;
  reference::TraceCounts counts;
  for (int number = 0; number < batches; ++number) {
    const transport::StratifiedBatch batch(1, element, static_cast<std::uint64_t>(number));
    Rgb sum = Rgb::Zero();
    for (int s = 0; s < transport::StratifiedBatch::kSize; ++s)
      sum += tracer.exitRadiance(point, outgoing, {batch, s}, counts);
    means.add(sum / transport::StratifiedBatch::kSize);
  }
  return means;
}

inline double standardError(const reference::BatchMeans& means) {
  return std::sqrt(means.luminanceVariance());
}

// A small picture with a transparent background.
inline reference::Options pictureOptions(int width_px, int height_px, int samples) {
  reference::Options options;
  options.frame.width_px = width_px;
  options.frame.height_px = height_px;
  options.frame.background = formats::Background::kTransparent;
  options.effort = {0, samples};
  return options;
}

inline reference::Reference render(const reference::Surface& surface, const formats::LightRig& rig,
                                   const reference::Options& options) {
  return reference::makeReference(surface, rig, options, std::nullopt, stage::ProgressStyle::kNone);
}

// Differences of pixels that are covered wholly, in units of their standard errors.
struct PixelStatistics {
  int pixels = 0;
  double mean_z = 0;  // of the sum of all pixels: a standard normal number if the means agree and pixels
                      // are independent, which those interpolated from the same vertices are not
  double mean_difference = 0;
  double chi_squared = 0;  // a pixel; about 1
};

// Of luminance-like R, against `expected(pixel)` with variance `expected_variance(pixel)`.
template <class Expected, class Variance>
PixelStatistics compareWith(const formats::Image& image, const Expected& expected,
                            const Variance& expected_variance) {
  PixelStatistics result;
  double difference = 0, variance = 0;
  for (std::size_t pixel = 0; pixel < image.values.size() / image.channelCount(); ++pixel) {
    const float* values = &image.values[pixel * image.channelCount()];
    if (values[3] != 1) continue;
    const double here = values[0] - expected(pixel), both = values[4] + expected_variance(pixel);
    ++result.pixels;
    difference += here;
    variance += both;
    result.chi_squared += here * here / both;
  }
  result.mean_z = difference / std::sqrt(variance);
  result.mean_difference = difference / result.pixels;
  result.chi_squared /= result.pixels;
  return result;
}

}  // namespace bakelight::tests
