// What each subsample of a picture sees, traced once for a mesh and a camera and reused for every pack and
// light on it.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"
#include "transport/camera.h"
#include "transport/cpu_renderer.h"
#include "transport/light_rig.h"
#include "transport/pack_shading.h"

namespace bakelight::report {

// The camera of a picture, from what its file says. Throws std::invalid_argument if eye and target coincide.
transport::OrbitCamera cameraFrom(const transport::Vec3& eye, const transport::Vec3& target,
                                  double field_of_view_deg);

struct GBuffer {
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  transport::PictureGrid grid;
  std::size_t object_triangles = 0;
  // Pixel after pixel, supersampling² each; triangles of the object, then of the emitters, or kNothing.
  std::vector<transport::SurfaceHit> hits;
};

// `emitters` stand in world space, as the camera does; the object is turned about the camera's target. Cost:
// one ray a subsample, on all TBB threads.
GBuffer traceGBuffer(const formats::TriangleMesh& object, const transport::EmitterMesh& emitters,
                     const Eigen::Matrix3d& world_from_object, const transport::OrbitCamera& camera,
                     const transport::PictureGrid& grid);

struct Picture {
  formats::Image linear;  // R, G, B, A: radiance, premultiplied, on a transparent background
  // 1 a pixel: every subsample sees the object.
  std::vector<std::uint8_t> covered;
};

// Radiance of hits on the object, and of those on the emitters.
Picture pictureOf(const GBuffer& gbuffer, const transport::RadianceAtHits& object,
                  const transport::RadianceAtHits& emitters);

}  // namespace bakelight::report
