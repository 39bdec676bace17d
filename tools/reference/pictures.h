// Pictures with the variance of each pixel.
#pragma once

#include "formats/image.h"
#include "tools/reference/estimates.h"
#include "tools/reference/ground.h"
#include "tools/reference/path_tracer.h"
#include "transport/cpu_renderer.h"

namespace bakelight::reference {

struct View {
  transport::OrbitCamera camera;
  int width_px = 0, height_px = 0;
  transport::Backdrop backdrop;
  std::optional<Ground> ground = {};  // tracePixels alone shows it
};

struct Picture {
  // R, G, B, A: linear radiance, premultiplied; variance.R, .G, .B: of the mean that stands in R, G and B.
  formats::Image image;
  RoundsReport
      report;  // its relative error is that of luminance, over pixels that see the object or the ground:
               // √(Σ variance) ÷ √(Σ mean²)
  std::size_t object_pixels = 0;
};

// Paths through each pixel, whose box is sampled evenly. The same bytes whatever the threads.
Picture tracePixels(const Scene& scene, const PathTracer& tracer, const View& view, const Effort& effort,
                    std::uint64_t seed, stage::ProgressStyle progress);

// Paths from the vertices towards the eye, interpolated over the triangles as the player does: the best that
// a bake without any other error could do. Pixels are box-filtered by kInterpolatedSubsamples² fixed rays,
// whose error is none of noise; the variance is that of the vertices, by the squares of their weights.
// Vertices that no pixel shows are left out.
inline constexpr int kInterpolatedSubsamples = 8;
Picture traceVertices(const Scene& scene, const PathTracer& tracer, const View& view, const Effort& effort,
                      std::uint64_t seed, stage::ProgressStyle progress);

// The same with those values at the vertices that, interpolated, come nearest to the exit radiance all over the triangles
// (transport/vertex_fit.h): the best that a bake with a fit could do. Paths start all over the triangles up to
// kFittedRings around the vertices that a pixel shows. The variance is that between kFittedGroups groups of batches, each
// of which has a fit of its own; fits are linear, so it is that of their mean.
inline constexpr int kFittedRings = 2;
inline constexpr int kFittedGroups = 8;
Picture traceTriangles(const Scene& scene, const PathTracer& tracer, const View& view, const Effort& effort,
                       std::uint64_t seed, stage::ProgressStyle progress);

}  // namespace bakelight::reference
