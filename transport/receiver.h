// A body that moves around an object and gets its shadow: what it is and where, for the player and for pictures on the CPU.
#pragma once

#include "formats/triangle_mesh.h"
#include "transport/camera.h"

namespace bakelight::transport {

struct Receiver {
  formats::TriangleMesh mesh;  // with normals, around its own middle, of radius 1
  formats::Float3 position = {
      1.4F, 0, 0};  // of its middle at time 0, from the object's, in radii of the object's bounding sphere
  double radius = 0.3;  // in the same
  formats::Float3 albedo = {0.7F, 0.7F, 0.7F};
  double orbit_s = 0;  // seconds that it takes once around the object, about +Y; 0: it stands still

  // As `position`, later.
  Vec3 middleAt(double time_s) const;
};

formats::TriangleMesh unitSphere();
// Brought to the middle of its bounding sphere, of radius 1.
formats::TriangleMesh unitSized(formats::TriangleMesh mesh);

}  // namespace bakelight::transport
