// A light rig: everything that shines on an object, as a small JSON file (docs/LIGHTS.md). Distant lights
// are seen alike from everywhere; emitters are bodies in the object's space, which the near-field runtime
// renders; punctual lights are points in the object's space that cast sharp shadows.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "formats/image.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Directions point towards the light; `intensity` multiplies whatever a light sends.
struct EnvironmentLight {  // "environment"
  std::filesystem::path path;
  Image image;         // R, G, B: lat-long (2:1), or a cube map as a strip of six faces (6:1, or 1:6)
  double yaw_deg = 0;  // turns it about +Y, right-handed
  double intensity = 1;
  std::vector<std::string> notes = {};  // of its reader, for the user
};
struct DiskLight {  // "disk"
  Float3 direction = {0, 1, 0};
  double half_angle_deg = 10;  // 0 < … ≤ 180
  Float3 radiance = {1, 1, 1};
};
struct PolygonLight {  // "polygon"
  std::vector<Float3>
      vertices;  // as seen from the object, in order, at least 3; spans less than a hemisphere
  Float3 radiance = {1, 1, 1};
};
struct DirectionalLight {  // "directional"
  Float3 direction = {0, 1, 0};
  Float3 irradiance = {1, 1, 1};  // on a surface that faces it
};
struct SkyLight {        // "sky": Preetham, Shirley & Smits 1999, with the sun's disk
  double turbidity = 3;  // 1.7–10
  double sun_elevation_deg = 40, sun_azimuth_deg = 0;  // azimuth 0 is +Z, 90 is +X
  bool sun = true;
  Float3 ground_albedo = {0.2F, 0.2F, 0.2F};  // below the horizon: what a Lambertian plane sends back
  double intensity = 1;                       // times the model's absolute radiance ÷ 1000
};
using DistantLight = std::variant<EnvironmentLight, DiskLight, PolygonLight, DirectionalLight, SkyLight>;

// How an emitter moves: around `axis` through `center`, or to and fro from its place to `to`. Period in
// seconds.
struct Motion {
  enum class Kind { kStill, kOrbit, kShuttle } kind = Kind::kStill;
  Float3 axis = {0, 1, 0}, center = {0, 0, 0}, to = {0, 0, 0};
  double period_s = 8;
};
struct Emitter {
  enum class Shape { kQuad, kSphere, kMesh } shape = Shape::kQuad;
  Float3 position = {0, 0, 0};   // centre
  Float3 normal = {0, 0, 1};     // quad: where it faces; both sides shine
  double width = 1, height = 1;  // quad
  double radius = 0.5;           // sphere
  std::filesystem::path path;    // mesh: any that importMesh reads
  double scale = 1;              // mesh
  TriangleMesh mesh;             // mesh, as read, about its own origin
  Float3 radiance = {1, 1, 1};
  Motion motion;
};

// A point that shines (as in glTF's KHR_lights_punctual).
struct PunctualLight {
  enum class Type {
    kPoint,  // "point": alike in all directions
    kSpot,   // "spot": a cone with a soft edge
    kSlide   // "slide": a point light behind a picture, as a slide projector is
  } type = Type::kPoint;
  Float3 position = {0, 0, 0};
  Float3 intensity = {1, 1,
                      1};  // radiant intensity: irradiance at a distance of 1 of the rig's units of length
  Float3 direction = {0, 0, -1};  // spot, slide: where it shines
  // Spot: within `inner` all of it, from there to `outer` less and less, beyond nothing; 0 ≤ inner < outer ≤ 90.
  double inner_half_angle_deg = 0, outer_half_angle_deg = 45;
  Float3 up = {
      0, 1, 0};  // slide: where the picture's upper edge is, as far as it is at right angles to `direction`
  double field_of_view_deg = 30;  // slide: from lower to upper edge
  // Slide: R, G, B ≥ 0, of square pixels of even light, rows from the top. Its middle is in `direction`, the right of the picture to
  // the right of one who looks there. A pixel multiplies the intensity of the directions that pass it, beyond the edges it is dark.
  std::filesystem::path path;
  std::shared_ptr<const Image> image;
  Motion motion;
};

struct LightRig {
  std::vector<DistantLight> distant;
  std::vector<Emitter> emitters;
  std::vector<PunctualLight> punctual;
  // Lengths of emitters and punctual lights are in units of the object's bounding-sphere radius, from its centre, if this holds
  // ("units": "object"); else in the asset's units ("units": "world").
  bool object_units = true;
  // 0 none … : strength of the window against ringing (transport/windowing.h); negative: just enough.
  double windowing = 0;

  bool empty() const { return distant.empty() && emitters.empty() && punctual.empty(); }
};

}  // namespace bakelight::formats
