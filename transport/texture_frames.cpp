#include "transport/texture_frames.h"

#include <cmath>
#include <stdexcept>

#include "transport/vector_types.h"

namespace bakelight::transport {

using formats::Float3;
using formats::Float4;

Float4 anyTangent(const Float3& normal) {
  const Vec3 n = vec3(normal).normalized();
  const double sign = std::copysign(1.0, n.z()), a = -1 / (sign + n.z());
  const Float3 t = float3(Vec3(1 + sign * n.x() * n.x() * a, sign * n.x() * n.y() * a, -sign * n.x()));
  return {t[0], t[1], t[2], 1.0F};
}

Float4 tangentAlong(const Float3& direction, const Float3& normal, float handedness) {
  const Vec3 n = vec3(normal).normalized(), d = vec3(direction);
  const Vec3 flat = d - n * n.dot(d);
  // Less is rounding of a direction along the normal.
  if (!(flat.norm() > 1e-6 * d.norm())) {
    Float4 tangent = anyTangent(normal);
    tangent[3] = handedness;
    return tangent;
  }
  const Float3 t = float3(Vec3(flat.normalized()));
  return {t[0], t[1], t[2], handedness};
}

double surfaceUnitOf(const formats::TriangleMesh& mesh) {
  double area = 0, plane_area = 0;
  for (const formats::Triangle& triangle : mesh.triangles) {
    const Vec3 origin = vec3(mesh.positions[triangle[0]]);
    area +=
        (vec3(mesh.positions[triangle[1]]) - origin).cross(vec3(mesh.positions[triangle[2]]) - origin).norm();
    const auto &a = mesh.texcoords[triangle[0]], &b = mesh.texcoords[triangle[1]],
               &c = mesh.texcoords[triangle[2]];
    plane_area += std::abs((double{b[0]} - a[0]) * (double{c[1]} - a[1]) -
                           (double{c[0]} - a[0]) * (double{b[1]} - a[1]));
  }
  return area > 0 && plane_area > 0 ? std::sqrt(area / plane_area) : 1;
}

PatchRepeats patchRepeats(const formats::TriangleMesh& mesh, std::optional<double> width) {
  const double unit = surfaceUnitOf(mesh);
  double repeats = unit / width.value_or(unit);
  if (repeats >= 1) repeats = std::round(repeats);
  return {repeats, unit / repeats};
}

TextureFrames textureFrames(const formats::TriangleMesh& mesh) {
  const std::size_t count = mesh.vertexCount();
  if (mesh.normals.size() != count || mesh.texcoords.size() != count)
    throw std::invalid_argument("frames along texture coordinates need these and normals");
  std::vector<Vec3> along_u(count, Vec3::Zero());
  std::vector<double> orientation(count, 0);  // area that is not mirrored, less area that is
  for (const formats::Triangle& triangle : mesh.triangles) {
    const Vec3 origin = vec3(mesh.positions[triangle[0]]);
    const Vec3 e1 = vec3(mesh.positions[triangle[1]]) - origin,
               e2 = vec3(mesh.positions[triangle[2]]) - origin;
    const auto& uv = mesh.texcoords;
    const double u1 = double{uv[triangle[1]][0]} - uv[triangle[0]][0],
                 v1 = double{uv[triangle[1]][1]} - uv[triangle[0]][1],
                 u2 = double{uv[triangle[2]][0]} - uv[triangle[0]][0],
                 v2 = double{uv[triangle[2]][1]} - uv[triangle[0]][1];
    const double determinant = u1 * v2 - u2 * v1, area = e1.cross(e2).norm();
    if (determinant == 0 || area == 0) continue;
    const Vec3 direction = (v2 * e1 - v1 * e2) * std::copysign(1.0, determinant);
    if (direction.norm() == 0) continue;
    for (const std::uint32_t v : triangle) {
      along_u[v] += area * direction.normalized();
      orientation[v] += std::copysign(area, determinant);
    }
  }
  TextureFrames frames;
  frames.tangents.reserve(count);
  for (std::size_t v = 0; v < count; ++v) {
    const Vec3 n = vec3(mesh.normals[v]).normalized();
    const float handedness = orientation[v] < 0 ? -1.0F : 1.0F;
    if (!((along_u[v] - n * n.dot(along_u[v])).norm() > 1e-6 * along_u[v].norm())) ++frames.undetermined;
    if (handedness < 0) ++frames.mirrored;
    frames.tangents.push_back(tangentAlong(float3(along_u[v]), mesh.normals[v], handedness));
  }
  return frames;
}

}  // namespace bakelight::transport
