// Patches on macro surfaces, as packs and as the geometry that these stand for.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include "formats/light_rig.h"
#include "formats/pack_contents.h"
#include "formats/triangle_mesh.h"
#include "patch/patch_geometry.h"
#include "tools/reference/scene.h"
#include "tools/rtt/rtt.h"
#include "transport/pack_shading.h"

namespace bakelight::bench {

using formats::Float3;
using formats::TriangleMesh;
using transport::Vec3;

// Macro surfaces around y, their middles facing +y; u along +x, v along −z there.
enum class Macro {
  kPlane,     // 8 × 8 patches
  kCylinder,  // 24 × 4 patches, around an axis along z, from outside
  kTrough     // half a cylinder from inside: 12 × 12 patches, whose sides shadow and light each other
};
const char* nameOf(Macro macro);
inline constexpr double kPatchWidth = 1;  // on the surface
// `steps` quads along a patch.
TriangleMesh macroMesh(Macro macro, int steps);

// At `across` and `up` widths from its middle.
struct MacroPoint {
  transport::SurfaceHit hit;  // of macroMesh
  Vec3 position, normal;      // of the ideal surface
};
MacroPoint macroPoint(Macro macro, int steps, double across, double up);

// What of the bake is varied.
struct BakeVariant {
  int order = 5;        // of light, macro transfer and patch
  int views = 8;        // a side
  int resolution = 64;  // texels
  int macro_steps = 2;  // vertices along a patch
  // Matrices that leave light below a vertex's own horizon alone, as patches do not see it.
  bool open_horizon = true;  // as the recipe bakes
  bool relief = true;        // views looked up along it
  bool bounces = true;       // at both scales

  auto operator<=>(const BakeVariant&) const = default;
};

patch::PatchGeometry patchOf(const std::string& name);  // of configs/patches
const rtt::Rtt& rttOf(const std::string& patch_name, const BakeVariant& variant);

struct Packs {
  formats::Pack bi_scale;
  formats::Pack macro_only;  // flat, of the patch's mean albedo
  formats::Pack meso_only;   // light as if the macro surface shadowed nothing: turned, no more
};
Packs packsOf(const std::string& patch_name, Macro macro, const BakeVariant& variant);

// Of all frequencies: a cube map of light of 6 × 32 × 32 texels of 2 × 2 rays, BTFs of 8 × 8 lights, packed as the recipe does. The macro surface's transfer is direct
// light alone, whatever the variant says.
formats::Pack allFrequencyPackOf(const std::string& patch_name, Macro macro, const BakeVariant& variant);

// What reference traces: the patch's own triangles all over the macro surface.
reference::Surface truthOf(const std::string& patch_name, Macro macro);

}  // namespace bakelight::bench
