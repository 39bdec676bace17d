// Near-field emitters, seen from a point. Apart from their placing, as that needs no rays.
#include <tbb/parallel_for.h>

#include <algorithm>

#include "transport/cube_map.h"
#include "transport/light_rig.h"
#include "transport/ray_scene.h"

namespace bakelight::transport {

formats::Image renderEmitterCube(const EmitterMesh& emitters, const Vec3& center, int resolution_px) {
  const RayScene scene(emitters.mesh);
  const CubeStrip layout{resolution_px, true};
  formats::Image strip(kCubeFaces * resolution_px, resolution_px, {"R", "G", "B"});
  tbb::parallel_for(0, resolution_px, [&](int y) {
    for (int face = 0; face < kCubeFaces; ++face)
      for (int x = 0; x < resolution_px; ++x) {
        const Vec3 direction =
            directionOfCubeFace(face, (x + 0.5) / resolution_px, (y + 0.5) / resolution_px);
        const Hit hit = scene.nearestHit(center, direction);
        if (!hit.valid) continue;
        const Float3& radiance = emitters.radiance[emitters.mesh.triangles[hit.triangle][0]];
        const auto [column, row] = layout.texelAt(face, x, y);
        std::copy(radiance.begin(), radiance.end(), strip.texel(column, row));
      }
  });
  return strip;
}

}  // namespace bakelight::transport
