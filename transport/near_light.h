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

}  // namespace bakelight::transport
