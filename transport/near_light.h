// What near emitters send to a pack.
#pragma once

#include <Eigen/Core>

#include "transport/lighting.h"
#include "transport/pack_shading.h"

namespace bakelight::transport {

// Turns positions about `center`.
void turnAbout(const Vec3& center, const Eigen::Matrix3d& rotation, std::vector<Float3>& positions);

// SH light that the near centre of `needs` sees of the emitters at `time_s`, in the frame of an object `mesh`
// that is turned about its bounding sphere's centre. As PackShading::setLight takes it; empty without
// emitters. Cost: one ray a texel of the cube map (Lighting::cube_resolution).
ShLight nearLight(const formats::TriangleMesh& mesh, const LightNeeds& needs, const Lighting& lighting,
                  double time_s, const Eigen::Matrix3d& world_from_object);

// The punctual lights at `time_s`, in the frame of an object that is turned so.
std::vector<PlacedPunctualLight> punctualLightsOn(const formats::TriangleMesh& mesh,
                                                  const formats::LightRig& near, double time_s,
                                                  const Eigen::Matrix3d& world_from_object);

// Shadows of a mesh, as Occlusion; keeps a scene of its own.
Occlusion shadowsOf(const formats::TriangleMesh& mesh);

// The whole light for LightNeeds::cube_side, as PackShading::setCubeLight takes it: distant, turned by `object_from_light`, and
// emitters as if from far away.
std::vector<Float3> cubeLightOn(const formats::TriangleMesh& mesh, const LightNeeds& needs,
                                const Lighting& lighting, const Eigen::Matrix3d& object_from_light,
                                const Eigen::Matrix3d& world_from_object, double time_s);

// All light that exposure goes by (exposureFactor): distant, as it stands, and of near light what there is at time 0. Its first coefficient counts.
ShLight exposureLight(const formats::TriangleMesh& mesh, const LightNeeds& needs, const Lighting& lighting);

// Gives `shading` its light in the form that it needs, coefficients or a cube map, and punctual lights in the shadow of `mesh`: all above.
void lightShading(PackShading& shading, const formats::TriangleMesh& mesh, const Lighting& lighting,
                  const Eigen::Matrix3d& object_from_light, const Eigen::Matrix3d& world_from_object,
                  double time_s);

}  // namespace bakelight::transport
