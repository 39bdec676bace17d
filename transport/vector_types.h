// Directions and positions in the maths of light transport, and their bridge to the plain arrays of formats.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "formats/triangle_mesh.h"

namespace bakelight::transport {

using Vec3 = Eigen::Vector3d;
using formats::Float3;

inline Vec3 vec3(const Float3& v) {
  return {v[0], v[1], v[2]};
}
inline Float3 float3(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace bakelight::transport
