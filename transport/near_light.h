// What near emitters send to a pack.
#pragma once

#include <Eigen/Core>

#include "formats/pack_contents.h"
#include "transport/lighting.h"

namespace bakelight::transport {

// Turns positions about `center`.
void turnAbout(const Vec3& center, const Eigen::Matrix3d& rotation, std::vector<Float3>& positions);

// SH light (order² of the pack) that the centre of the pack's virtual sphere sees of the emitters at
// `time_s`, in the frame of an object that is turned about its bounding sphere's centre; that centre sees it
// for a pack without near vectors. As PackEvaluator::setLight takes it; empty without emitters. Cost: one ray
// a texel of the cube map (Lighting::cube_resolution).
ShLight nearLight(const formats::Pack& pack, const Lighting& lighting, double time_s,
                  const Eigen::Matrix3d& world_from_object);

}  // namespace bakelight::transport
