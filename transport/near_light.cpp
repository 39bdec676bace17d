#include "transport/near_light.h"

#include <algorithm>
#include <memory>

#include "transport/camera.h"
#include "transport/cube_light.h"
#include "transport/cube_map.h"
#include "transport/light_rig.h"
#include "transport/ray_scene.h"
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

}  // namespace

ShLight nearLight(const formats::TriangleMesh& mesh, const LightNeeds& needs, const Lighting& lighting,
                  double time_s, const Eigen::Matrix3d& world_from_object) {
  if (lighting.near.emitters.empty()) return {};
  return projectCubeMap(
      emitterCube(mesh, needs, lighting, time_s, world_from_object, lighting.cube_resolution), needs.sh_order,
      "emitters");
}

std::vector<PlacedPunctualLight> punctualLightsOn(const formats::TriangleMesh& mesh,
                                                  const formats::LightRig& near, double time_s,
                                                  const Eigen::Matrix3d& world_from_object) {
  const BoundingSphere bounds = boundingSphere(mesh);
  std::vector<PlacedPunctualLight> lights = placedPunctualLights(near, bounds, time_s);
  turnAbout(bounds.center, world_from_object.transpose(), lights);
  return lights;
}

Occlusion shadowsOf(const formats::TriangleMesh& mesh) {
  return [rays = std::make_shared<const RayScene>(mesh)](const Vec3& origin, const Vec3& direction,
                                                         double distance) {
    return rays->occluded(origin, direction, static_cast<float>(distance));
  };
}

std::vector<Float3> cubeLightOn(const formats::TriangleMesh& mesh, const LightNeeds& needs,
                                const Lighting& lighting, const Eigen::Matrix3d& object_from_light,
                                const Eigen::Matrix3d& world_from_object, double time_s) {
  const int side = needs.cube_side;
  std::vector<Float3> radiance = cubeLight(lighting.sources, side, object_from_light);
  if (lighting.near.emitters.empty()) return radiance;
  addCubeMap(emitterCube(mesh, needs, lighting, time_s, world_from_object,
                         cubeResolutionFor(side, lighting.cube_resolution)),
             side, radiance);
  return radiance;
}

ShLight exposureLight(const formats::TriangleMesh& mesh, const LightNeeds& needs, const Lighting& lighting) {
  ShLight light = lighting.distant;
  const ShLight near = nearLight(mesh, needs, lighting, 0, Eigen::Matrix3d::Identity());
  if (!near.empty()) light = sum(light, near);
  return withMeanLight(std::move(light), placedPunctualLights(lighting.near, boundingSphere(mesh), 0),
                       boundingSphere(mesh).center);
}

void lightShading(PackShading& shading, const formats::TriangleMesh& mesh, const Lighting& lighting,
                  const Eigen::Matrix3d& object_from_light, const Eigen::Matrix3d& world_from_object,
                  double time_s) {
  const LightNeeds needs = shading.needs();
  const std::vector<PlacedPunctualLight> punctual =
      punctualLightsOn(mesh, lighting.near, time_s, world_from_object);
  shading.setPunctualLights(punctual, punctual.empty() ? Occlusion() : shadowsOf(mesh));
  if (needs.cube_side > 0)
    return shading.setCubeLight(
        cubeLightOn(mesh, needs, lighting, object_from_light, world_from_object, time_s));
  shading.setLight(ShRotation(needs.sh_order, object_from_light).apply(lighting.distant),
                   nearLight(mesh, needs, lighting, time_s, world_from_object));
}

}  // namespace bakelight::transport
