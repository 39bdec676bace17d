// Pictures of a piece of a surface, along parallel rays, by paths through its geometry and by what stands for it.
#pragma once

#include <span>
#include <vector>

#include "formats/light_rig.h"
#include "formats/pack_contents.h"
#include "patch/patch_geometry.h"
#include "tests/bench/biscale_subject.h"
#include "tools/reference/path_tracer.h"
#include "tools/reference/scene.h"
#include "transport/lights.h"

namespace bakelight::bench {

// A pixel for each cell of a grid over some of the macro surface, around its middle: what is seen through it
// along parallel rays, however far the geometry below is displaced.
struct Window {
  int side = 128;                          // pixels
  double widths = 1;                       // of the patch
  double polar_deg = 0, azimuth_deg = 30;  // of the view, in the frame of its middle
  Vec3 towardsEye() const;
  double at(double pixel) const { return (pixel / side - 0.5) * widths; }  // widths from the middle
};

struct Image {
  int side = 0;
  std::vector<Float3> values;  // rows upwards
  double variance = 0;         // Σ over pixels and colors, of values that have noise

  Image blurred(int pixels) const;  // boxes of pixels × pixels become one
};

// Σ (image − truth)² and Σ truth², each less what noise of the truth adds.
struct SquaredError {
  double difference = 0, square = 0;
  void add(const Image& image, const Image& truth);
  void add(const SquaredError& other);
  double relative() const;  // root mean square
};

Image truthImage(const reference::Scene& scene, Macro macro, const Window& window, int batches,
                 reference::Transport transport = reference::Transport::kFull);
// Of a pack over macroMesh of `steps`, by its shading, to which light has been given.
Image shadedImage(transport::PackShading& shading, Macro macro, int steps, const Window& window);
// `steps` of the pack's macroMesh.
Image packImage(const formats::Pack& pack, Macro macro, int steps, std::span<const Float3> light,
                const Window& window);

// Albedo and normal of what is seen from straight above, a texel each: a normal map with plain shading, whose light comes from
// all of the hemisphere above the normal.
struct NormalMap {
  int side = 0;
  std::vector<Float3> albedo;
  std::vector<Vec3> normals;  // in the patch's frame
};
NormalMap normalMapOf(const patch::PatchGeometry& geometry, int side);
Image normalMapImage(const NormalMap& map, Macro macro, std::span<const Float3> light, const Window& window);

}  // namespace bakelight::bench
