// The orbit camera that the player, previews and reference renders share, so that their pictures coincide.
#pragma once

#include <Eigen/Core>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

struct BoundingSphere {
  Vec3 center = Vec3::Zero();
  double radius = 0;
};

// Around the bounding box's centre; radius to the farthest vertex. Radius 0 for an empty mesh.
BoundingSphere boundingSphere(const formats::TriangleMesh& mesh);

// Looks at `target`; yaw 0 looks along −Z (the camera stands at +Z), a positive yaw moves the camera towards
// +X, a positive pitch raises it. `field_of_view_deg` is vertical.
struct OrbitCamera {
  Vec3 target = Vec3::Zero();
  double distance = 1;
  double yaw_deg = 0, pitch_deg = 0;  // pitch −89 … 89
  double field_of_view_deg = 35;

  Vec3 eye() const;
  Eigen::Matrix4d viewFromWorld() const;
  // OpenGL clip space, z from −1 to 1; near and far enclose `bounds` (clamped to a thousandth of the distance
  // at least).
  Eigen::Matrix4d clipFromView(double aspect, const BoundingSphere& bounds) const;
  // Unit world direction through pixel coordinates (x right, y down; the first pixel's centre is at 0.5,
  // 0.5).
  Vec3 directionThrough(double x_px, double y_px, int width_px, int height_px) const;
  // Radians that a pixel in the middle of the picture covers.
  double pixelAngle(int height_px) const;
};

// The camera that frames `bounds` with a small margin, for any aspect ratio: distance is radius / sin(half
// the smaller field of view).
OrbitCamera frameSphere(const BoundingSphere& bounds, double yaw_deg, double pitch_deg,
                        double field_of_view_deg, double aspect);

}  // namespace bakelight::transport
