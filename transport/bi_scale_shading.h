// Bi-scale shading (Sloan, Liu, Shum & Snyder 2003, equation 4): B(q(u), v) · (M L). Transfer matrices at the vertices turn
// the light into what falls on the meso-structure; radiance transfer textures, looked up a hit, into what leaves it
// towards the eye. What the player's shaders compute, on the CPU.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "formats/rtt_reflection.h"
#include "transport/glossy_evaluator.h"
#include "transport/pack_shading.h"
#include "transport/patch_lookup.h"

namespace bakelight::transport {

// B of a Lambertian plane of albedo 1: A_l/π · √((2l+1)/4π) at m = 0. One component, one texel, one view.
formats::RttReflection flatReflection(int order);

class BiScaleShading final : public PackShading {
 public:
  // SH transfer with an operator, and a radiance transfer texture in some appearance; the others are Lambertian.
  static bool shades(const formats::Pack& pack);
  // Throws std::invalid_argument if the pack's tables do not fit its mesh.
  explicit BiScaleShading(const formats::Pack& pack);

  LightNeeds needs() const override;
  // M L at each vertex, and its products with the textures' bases. Near light comes as if from far away. On all TBB
  // threads.
  void setLight(std::span<const Float3> distant, std::span<const Float3> near) override;
  void setView(const ViewPoint& view) override { view_ = view; }
  void radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const override;

 private:
  struct Patch;

  Float3 radianceAt(const SurfaceHit& hit) const;
  void project(std::span<const Float3> transferred);

  int order_;
  formats::TriangleMesh mesh_;
  std::vector<formats::Float4> tangents_;
  std::unique_ptr<const GlossyEvaluator> transfer_;
  std::size_t rows_;  // of transferred radiance
  std::vector<ShRotation>
      local_from_object_;  // a vertex, for visibility, whose rows are in the object's frame
  std::vector<std::shared_ptr<const Patch>> patches_;  // by appearance
  std::vector<formats::VertexRange> ranges_;           // by appearance
  std::vector<Float3> vertex_albedo_;                  // of Lambertian appearances; 1 elsewhere
  std::size_t components_ = 0;                         // the most that a patch has
  std::vector<Float3> projected_;                      // n × components_
  ViewPoint view_{Vec3(0, 0, 0)};
};

}  // namespace bakelight::transport
