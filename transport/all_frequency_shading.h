// Bi-scale shading of all frequencies: B(x, e) = Σ_d b(u, e, d) L*(x, d). Transfer in a pixel basis turns a cube map of light into
// what falls on the cells of the hemisphere over each vertex; BTFs, looked up a hit, say what leaves towards the eye. What the player's shaders compute, on the CPU.
//
// BTFs are factored, so the sums over d are taken at vertices: a dozen colors each, instead of 64 radiances. This is exact, as interpolation is linear. They are
// kept until the light changes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/btf_reflection.h"
#include "formats/pack_contents.h"
#include "formats/pixel_transfer.h"
#include "transport/pack_shading.h"
#include "transport/sum_product.h"

namespace bakelight::transport {

// A Lambertian plane of albedo 1: the mean cosine of each cell over π. One component, one texel, one view.
formats::BtfReflection flatBtf(int lights);

// Light of each texel for transfer in a pixel basis: `radiance`, its mean, × solid angle ÷ subsamples².
std::vector<Float3> texelLight(std::span<const Float3> radiance, int cube_side, int subsamples);

// 1 for each triangle whose corners' frames differ by more than the angle, by normals or tangents, or by their handedness: nothing
// is interpolated across it, and what is nearest to a corner by barycentric coordinates has that corner's frame and light.
std::vector<std::uint8_t> creasedTriangles(const formats::TriangleMesh& mesh,
                                           std::span<const formats::Float4> tangents,
                                           double crease_angle_deg);

class AllFrequencyShading final : public PackShading {
 public:
  // Transfer in a pixel basis, and reflections that are BTFs or Lambertian.
  static bool shades(const formats::Pack& pack);
  // Throws std::invalid_argument if the pack's tables do not fit its mesh or each other.
  explicit AllFrequencyShading(const formats::Pack& pack);

  LightNeeds needs() const override;
  // Throws std::logic_error: spherical harmonics are not what it needs.
  void setLight(std::span<const Float3> distant, std::span<const Float3> near) override;
  // L* at each vertex, and its products with the BTFs' bases. On all TBB threads.
  void setCubeLight(std::span<const Float3> radiance) override;
  // The same from L* that was worked out elsewhere: of each row of the transfer, radiance × solid angle that falls on its cell. What `incident`
  // says does not change. Throws std::invalid_argument for another number of rows.
  void setIncident(std::span<const Radiance4> rows);
  void setView(const ViewPoint& view) override { view_ = view; }
  void radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const override;

  // L* of a vertex: radiance × solid angle that falls on each of its cells, under the light of the last setCubeLight.
  std::vector<Float3> incident(std::size_t vertex) const;

 private:
  struct Patch;

  template <class FallingOn>
  void project(FallingOn falling_on);
  void incidentFromRows(std::size_t block, std::span<Float3> cells) const;
  void incidentFromSums(std::size_t block, std::span<Float3> cells) const;
  Float3 radianceAt(const SurfaceHit& hit) const;
  std::array<float, 3> frameWeights(const SurfaceHit& hit) const;

  formats::TriangleMesh mesh_;
  int cube_side_, subsamples_;
  std::size_t cells_;
  std::optional<formats::PixelTransferRows> rows_;  // or:
  std::shared_ptr<const formats::SumGrammar> sums_;
  std::vector<std::uint32_t> value_places_;  // of the sums' values: valuePlaces()
  std::vector<formats::Float4> tangents_;
  std::vector<std::uint32_t> blocks_;
  std::vector<std::uint8_t> creased_;                  // a triangle: its corners' frames differ too much
  std::vector<std::shared_ptr<const Patch>> patches_;  // by appearance
  std::vector<formats::VertexRange> ranges_;           // by appearance
  std::vector<Float3> vertex_albedo_;                  // of Lambertian appearances; 1 elsewhere
  std::size_t components_ = 0;                         // the most that a patch has
  std::vector<Float3> light_;      // for rows: radiance × solid angle ÷ subsamples², a texel
  std::vector<Radiance4> values_;  // of the sums under the light
  std::vector<Float3> projected_;  // n × components_
  ViewPoint view_{Vec3(0, 0, 0)};
};

}  // namespace bakelight::transport
