// Shading of a translucent object (formats/translucency.h): what enters at vertices by transfer vectors, what comes out by
// TranslucentResponse, and Fresnel's share of it towards the eye. What the player's technique shows, on the CPU.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formats/pack_contents.h"
#include "formats/words.h"
#include "transport/pack_shading.h"
#include "transport/texel_irradiance.h"
#include "transport/translucent_response.h"

namespace bakelight::transport {

inline constexpr formats::Word<TranslucentResponse::Branches> kTranslucentBranches[] = {
    {"both", TranslucentResponse::Branches::kBoth},
    {"local", TranslucentResponse::Branches::kLocal},
    {"global", TranslucentResponse::Branches::kGlobal}};

// One branch on its own, to compare (Lensch et al. 2002, figure 7): the pack without what the other adds. Throws std::invalid_argument
// for a pack that TranslucentShading does not shade, unless `branches` are both.
formats::Pack withBranches(formats::Pack pack, TranslucentResponse::Branches branches);

class TranslucentShading final : public PackShading {
 public:
  // SH transfer, and one appearance whose reflection is Translucency.
  static bool shades(const formats::Pack& pack);
  // Throws std::invalid_argument if the pack's tables do not fit its mesh.
  explicit TranslucentShading(const formats::Pack& pack);
  TranslucentShading(const TranslucentShading&) = delete;
  TranslucentShading& operator=(const TranslucentShading&) = delete;

  LightNeeds needs() const override { return {order_, near_center_, 0, true}; }
  // Transfer vectors hold what the surface lets in already; where spherical harmonics ring below 0, nothing enters. On all TBB threads; same bytes for any number.
  void setLight(std::span<const Float3> distant, std::span<const Float3> near) override;
  void setPunctualLights(std::span<const PlacedPunctualLight> lights, const Occlusion& occluded) override;
  void setView(const ViewPoint& view) override { eye_ = view.eye; }
  void radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const override;

  // Radiosity below the surface, resolution² texels, rows from the top: RGB, and 1 where there is any, else 0. Pictures take
  // the mean of the four around a place by distance, of those that have a 1.
  std::span<const formats::Float4> radiosity() const { return radiosity_; }

 private:
  int order_, channels_, resolution_;
  double eta_;
  std::optional<Vec3> near_center_;
  std::vector<float> vectors_, near_vectors_;  // near_vectors_: empty where vectors_ serve for both
  formats::TriangleMesh mesh_;
  std::vector<Float3> stain_;
  std::vector<std::uint32_t> knots_;
  std::size_t knot_count_;
  std::vector<std::uint32_t> places_;  // of receivers
  TranslucentResponse response_;
  TexelIrradiance irradiance_;
  std::vector<Float3> punctual_;  // what enters of punctual lights, a texel; empty: nothing
  std::vector<formats::Float4> radiosity_;
  Vec3 eye_ = Vec3::Zero();
};

}  // namespace bakelight::transport
