#include "transport/near_light.h"

#include "transport/camera.h"
#include "transport/light_rig.h"

namespace bakelight::transport {

void turnAbout(const Vec3& center, const Eigen::Matrix3d& rotation, std::vector<Float3>& positions) {
  for (Float3& position : positions) position = float3(rotation * (vec3(position) - center) + center);
}

ShLight nearLight(const formats::TriangleMesh& mesh, const LightNeeds& needs, const Lighting& lighting,
                  double time_s, const Eigen::Matrix3d& world_from_object) {
  if (lighting.near.emitters.empty()) return {};
  const BoundingSphere bounds = boundingSphere(mesh);
  EmitterMesh emitters = emitterMesh(lighting.near, bounds, time_s);
  turnAbout(bounds.center, world_from_object.transpose(), emitters.mesh.positions);
  const Vec3 center = needs.near_center.value_or(bounds.center);
  const formats::Image cube = renderEmitterCube(emitters, center, lighting.cube_resolution);
  return projectCubeMap(cube, needs.sh_order, "emitters");
}

}  // namespace bakelight::transport
