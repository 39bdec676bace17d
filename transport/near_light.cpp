#include "transport/near_light.h"

#include <algorithm>

#include "transport/camera.h"
#include "transport/cube_light.h"
#include "transport/cube_map.h"
#include "transport/light_rig.h"
#include "transport/sh.h"

namespace bakelight::transport {

void turnAbout(const Vec3& center, const Eigen::Matrix3d& rotation, std::vector<Float3>& positions) {
  for (Float3& position : positions) position = float3(rotation * (vec3(position) - center) + center);
}

namespace {

// What is seen of the emitters, of which there are some.
formats::Image emitterCube(const formats::TriangleMesh& mesh, const LightNeeds& needs,
                           const Lighting& lighting, double time_s, const Eigen::Matrix3d& world_from_object,
                           int resolution_px) {
  const BoundingSphere bounds = boundingSphere(mesh);
  EmitterMesh emitters = emitterMesh(lighting.near, bounds, time_s);
  turnAbout(bounds.center, world_from_object.transpose(), emitters.mesh.positions);
  return renderEmitterCube(emitters, needs.near_center.value_or(bounds.center), resolution_px);
}

// Means of blocks of texels, by their solid angles.
void addBlocks(const formats::Image& strip, int side, int block, std::vector<Float3>& radiance) {
  for (int face = 0; face < kCubeFaces; ++face)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int j = y * block; j < (y + 1) * block; ++j)
          for (int i = x * block; i < (x + 1) * block; ++i) {
            const float* texel = strip.texel(face * side * block + i, j);
            sum += cubeTexelSolidAngle(i, j, side * block) * Eigen::Vector3d(texel[0], texel[1], texel[2]);
          }
        sum /= cubeTexelSolidAngle(x, y, side);
        Float3& target = radiance[static_cast<std::size_t>((face * side + y) * side + x)];
        for (std::size_t c = 0; c < 3; ++c)
          target[c] += static_cast<float>(sum[static_cast<Eigen::Index>(c)]);
      }
}

}  // namespace

ShLight nearLight(const formats::TriangleMesh& mesh, const LightNeeds& needs, const Lighting& lighting,
                  double time_s, const Eigen::Matrix3d& world_from_object) {
  if (lighting.near.emitters.empty()) return {};
  return projectCubeMap(
      emitterCube(mesh, needs, lighting, time_s, world_from_object, lighting.cube_resolution), needs.sh_order,
      "emitters");
}

std::vector<Float3> cubeLightOn(const formats::TriangleMesh& mesh, const LightNeeds& needs,
                                const Lighting& lighting, const Eigen::Matrix3d& object_from_light,
                                const Eigen::Matrix3d& world_from_object, double time_s) {
  const int side = needs.cube_side;
  std::vector<Float3> radiance = cubeLight(lighting.sources, side, object_from_light);
  if (lighting.near.emitters.empty()) return radiance;
  const int block = std::max(1, (lighting.cube_resolution + side - 1) / side);
  addBlocks(emitterCube(mesh, needs, lighting, time_s, world_from_object, side * block), side, block,
            radiance);
  return radiance;
}

void lightShading(PackShading& shading, const formats::TriangleMesh& mesh, const Lighting& lighting,
                  const Eigen::Matrix3d& object_from_light, const Eigen::Matrix3d& world_from_object,
                  double time_s) {
  const LightNeeds needs = shading.needs();
  if (needs.cube_side > 0)
    return shading.setCubeLight(
        cubeLightOn(mesh, needs, lighting, object_from_light, world_from_object, time_s));
  shading.setLight(ShRotation(needs.sh_order, object_from_light).apply(lighting.distant),
                   nearLight(mesh, needs, lighting, time_s, world_from_object));
}

}  // namespace bakelight::transport
