// From a light rig to what evaluation needs.
#pragma once

#include <array>
#include <vector>

#include "formats/light_rig.h"
#include "transport/camera.h"
#include "transport/lights.h"

namespace bakelight::transport {

// One light of a rig, before windowing; a sky with its ground and sun. Throws Error(kBadInput) for a cube map
// or polygon that is none, and for light that is not finite.
ShLight projectLight(const formats::DistantLight& light, int order);

struct RigLight {
  ShLight light;  // of all distant lights, after windowing; order² entries
  // Lat-long R, G, B of the same lights, for the picture: as wide as the widest environment, 512–2048 px.
  // Lights too small for it are spread over a texel with their power kept.
  formats::Image backdrop;
  double moved_energy = 0;  // share of the light's squared norm beyond band 0 that windowing took away
  double window = 0;        // strength that was used
};

// Throws Error(kBadInput) for light that is not finite.
RigLight distantLight(const formats::LightRig& rig, int order);

// Where what starts at `position` is at `time_s`: from its own space to the rig's, in the rig's unit of length.
Eigen::Isometry3d rigFromBody(const Float3& position, const formats::Motion& motion, double time_s);

// Emitters as one mesh of flat radiance, placed at `time_s`; in object space. Normals are filled in. Moving
// emitters are rigid: an orbit turns them along. A quad's width runs along +Y × normal (+X where that
// vanishes). A sphere is an icosphere of 1,280 triangles with the area of the ideal sphere; its surface stays
// within 0.3% of the radius.
struct EmitterMesh {
  formats::TriangleMesh mesh;
  std::vector<Float3> radiance;  // a vertex; constant over each emitter
};
EmitterMesh emitterMesh(const formats::LightRig& rig, const BoundingSphere& object, double time_s);

// What is seen from `center`: six faces (cube_map.h) of resolution² texels R, G, B, as a strip 6:1, by a ray
// through each texel's centre. Both sides of a triangle shine; nothing: black.
formats::Image renderEmitterCube(const EmitterMesh& emitters, const Vec3& center, int resolution_px);

// L_i = Σ texels radiance · y_i(centre direction) · exact solid angle. `strip` is 6:1 or 1:6. Throws
// Error(kBadInput) naming `file` for other shapes.
ShLight projectCubeMap(const formats::Image& strip, int order, const std::string& file);

}  // namespace bakelight::transport
