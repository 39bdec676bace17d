#include "transport/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bakelight::transport {
namespace {

constexpr double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// Columns: right, up, backward.
Eigen::Matrix3d worldFromView(const OrbitCamera& camera) {
  const double yaw = radians(camera.yaw_deg), pitch = radians(camera.pitch_deg);
  const Vec3 backward(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
  const Vec3 right(std::cos(yaw), 0, -std::sin(yaw));
  Eigen::Matrix3d axes;
  axes << right, backward.cross(right), backward;
  return axes;
}

}  // namespace

BoundingSphere boundingSphere(const formats::TriangleMesh& mesh) {
  if (mesh.positions.empty()) return {};
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& position : mesh.positions) {
    low = low.cwiseMin(vec3(position));
    high = high.cwiseMax(vec3(position));
  }
  BoundingSphere sphere{(low + high) / 2, 0};
  for (const auto& position : mesh.positions)
    sphere.radius = std::max(sphere.radius, (vec3(position) - sphere.center).norm());
  return sphere;
}

Vec3 OrbitCamera::eye() const {
  return target + distance * worldFromView(*this).col(2);
}

Eigen::Matrix4d OrbitCamera::viewFromWorld() const {
  const Eigen::Matrix3d axes = worldFromView(*this);
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.topLeftCorner<3, 3>() = axes.transpose();
  view.topRightCorner<3, 1>() = -(axes.transpose() * eye());
  return view;
}

Eigen::Matrix4d OrbitCamera::clipFromView(double aspect, const BoundingSphere& bounds) const {
  const double to_center = (eye() - bounds.center).norm();
  const double far_plane = std::max(to_center + bounds.radius, distance) * 1.01;
  const double near_plane = std::max(to_center - bounds.radius, distance * 1e-3) * 0.99;
  const double focal = 1 / std::tan(radians(field_of_view_deg) / 2);
  Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
  clip(0, 0) = focal / aspect;
  clip(1, 1) = focal;
  clip(2, 2) = (far_plane + near_plane) / (near_plane - far_plane);
  clip(2, 3) = 2 * far_plane * near_plane / (near_plane - far_plane);
  clip(3, 2) = -1;
  return clip;
}

double OrbitCamera::pixelAngle(int height_px) const {
  return 2 * std::tan(field_of_view_deg * std::numbers::pi / 360) / height_px;
}

Vec3 OrbitCamera::directionThrough(double x_px, double y_px, int width_px, int height_px) const {
  const double half = std::tan(radians(field_of_view_deg) / 2),
               aspect = static_cast<double>(width_px) / height_px;
  const Vec3 in_view((2 * x_px / width_px - 1) * half * aspect, (1 - 2 * y_px / height_px) * half, -1);
  return (worldFromView(*this) * in_view).normalized();
}

OrbitCamera frameSphere(const BoundingSphere& bounds, double yaw_deg, double pitch_deg,
                        double field_of_view_deg, double aspect) {
  constexpr double kMargin = 1.05;
  const double half_vertical = radians(field_of_view_deg) / 2;
  const double half_smaller = std::atan(std::tan(half_vertical) * std::min(1.0, aspect));
  OrbitCamera camera;
  camera.target = bounds.center;
  camera.distance = std::max(kMargin * bounds.radius / std::sin(half_smaller), 1e-9);
  camera.yaw_deg = yaw_deg;
  camera.pitch_deg = pitch_deg;
  camera.field_of_view_deg = field_of_view_deg;
  return camera;
}

}  // namespace bakelight::transport
