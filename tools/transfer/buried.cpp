#include "tools/transfer/buried.h"

#include <vector>

#include "transport/directions.h"

namespace bakelight::transfer {

using formats::Float3;
using transport::Vec3;
using transport::vec3;

namespace {

constexpr int kProbeDirections = 128;  // over the sphere

}  // namespace

bool isBuried(const transport::RayScene& scene, const Float3& origin, const Float3& normal) {
  static const std::vector<Vec3> directions = transport::sphereDirections(kProbeDirections);
  int front = 0, back = 0;
  for (const Vec3& direction : directions) {
    if (direction.dot(vec3(normal)) <= 0) continue;
    const transport::Hit hit = scene.nearestHit(vec3(origin), direction);
    if (hit.valid) ++(hit.back_face ? back : front);
  }
  return back > front;
}

}  // namespace bakelight::transfer
