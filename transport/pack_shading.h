// How a pack looks under a light and to an eye, asked at points of its surface: the one way in which tools
// see a pack on the CPU. Where its technique shades (at vertices, texels, pixels) is the technique's own
// matter.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/pack_contents.h"
#include "transport/punctual_light.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// A point of a triangle, by the weights of its second and third vertex.
struct SurfaceHit {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;
};

// What a technique asks of the light.
struct LightNeeds {
  int sh_order = 0;  // bands of its projection into spherical harmonics; 0: none
  // Where near emitters are seen from (object space); nothing: from the centre of the mesh's bounding sphere.
  std::optional<Vec3> near_center = {};
  // Texels along an edge of a cube map of it; 0: none. Then light comes by setCubeLight instead of setLight.
  int cube_side = 0;
  // Whether punctual lights can fall on it: only where light is taken at each place of the surface, not as coefficients.
  bool punctual = false;
};

// Whether the object itself lies along a ray (unit direction) at a distance from 0 to `distance`. From several threads at once.
using Occlusion = std::function<bool(const Vec3& origin, const Vec3& direction, double distance)>;

// Where a picture is seen from, in object space.
struct ViewPoint {
  Vec3 eye;
  // Radians that a sample of the picture covers; 0: none, every texture is seen as sharp as it is.
  double pixel_angle = 0;

  ViewPoint(const Vec3& at, double angle = 0) : eye(at), pixel_angle(angle) {}
};

class PackShading {
 public:
  virtual ~PackShading() = default;

  virtual LightNeeds needs() const = 0;
  // Light change: `distant` in the object's frame, at least sh_order² coefficients; `near`, empty or as many,
  // is what `near_center` sees of near emitters. Throws std::invalid_argument for fewer.
  virtual void setLight(std::span<const Float3> distant, std::span<const Float3> near) = 0;
  // Light change for those that need a cube map: mean radiance over each of its 6 · cube_side² texels, in the order of
  // transport/cube_map.h and in the object's frame. Throws std::invalid_argument for another number, std::logic_error from those that do not need one.
  virtual void setCubeLight(std::span<const Float3> radiance);
  // Change of punctual lights, in the object's frame, which takes effect with the next setLight; empty: none. Throws std::logic_error for
  // any from those whose needs are without, Error(kBadInput) for light that is not finite.
  virtual void setPunctualLights(std::span<const PlacedPunctualLight> lights, const Occlusion& occluded);
  // View change, or after a light change.
  virtual void setView(const ViewPoint& view) = 0;
  // Exit radiance of each hit towards the eye; black before the first setLight. From several threads at once.
  virtual void radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const = 0;
};

// A technique: which packs it shades, and how. The pack may go after `make`.
struct ShadingTechnique {
  const char* name;
  bool (*shades)(const formats::Pack& pack);
  std::unique_ptr<PackShading> (*make)(const formats::Pack& pack);
};
// The list; the last that shades a pack is taken. A technique of a program's own is added at its start.
std::vector<ShadingTechnique>& shadingTechniques();

// Throws std::invalid_argument if no technique shades the pack, or its parts do not fit its mesh.
std::unique_ptr<PackShading> makePackShading(const formats::Pack& pack);

// Throws Error(kBadInput) naming the rig's file if it has punctual lights, and a technique of such needs does not take them.
void requirePunctualTaken(const formats::LightRig& rig, const LightNeeds& needs, const std::string& file);

// Radiance of hits, for renderers: of a pack, or interpolated between the vertices of triangles.
using RadianceAtHits = std::function<void(std::span<const SurfaceHit>, std::span<Float3>)>;
RadianceAtHits radianceOf(const PackShading& shading);
// Both spans must outlive the result.
RadianceAtHits interpolated(std::span<const formats::Triangle> triangles,
                            std::span<const Float3> vertex_radiance);

}  // namespace bakelight::transport
