// The player's picture on the CPU: a ray through each subsample, and the radiance of its nearest hit. For
// previews, comparisons with the player, and machines without OpenGL.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "formats/image.h"
#include "transport/camera.h"
#include "transport/pack_shading.h"
#include "transport/ray_scene.h"

namespace bakelight::transport {

struct PictureGrid {
  int width_px = 0, height_px = 0;
  int supersampling = 1;  // subsamples per axis, at the centres of supersampling² equal squares
};

// What a ray without a hit sees: radiance and coverage (premultiplied RGBA) for a unit world direction.
// Called from several threads at once.
using Backdrop = std::function<formats::Float4(const Vec3&)>;

struct SubsampleHit {
  float distance = std::numeric_limits<float>::infinity();  // from the eye; infinite without a hit
  std::uint32_t triangle = 0;

  bool valid() const { return distance < std::numeric_limits<float>::infinity(); }
};

struct CpuPicture {
  formats::Image linear;  // R, G, B, A: mean over each pixel's subsamples, premultiplied
  std::vector<SubsampleHit>
      hits;  // (width · supersampling) × (height · supersampling), rows from top to bottom
};

// Both sides of a triangle are seen; `shade` is asked for hits on the scene's triangles, row by row from
// several threads at once. Throws std::invalid_argument if the grid is empty. Cost: one nearest-hit ray per
// subsample, on all TBB threads; the same bytes whatever their number.
CpuPicture renderOnCpu(const RayScene& scene, const RadianceAtHits& shade, const OrbitCamera& camera,
                       const PictureGrid& grid, const Backdrop& backdrop);

// Exposure (a factor) and display code for each pixel of a premultiplied R, G, B, A image: values k/255 with
// colour not premultiplied, as formats::writePng takes them.
formats::Image encodeForDisplay(const formats::Image& linear, float exposure);

}  // namespace bakelight::transport
