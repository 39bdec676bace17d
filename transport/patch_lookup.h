// Looking up patches of meso-structure at a point of a surface: what bi-scale techniques share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/factored_patch.h"
#include "formats/triangle_mesh.h"
#include "transport/hemisphere_grid.h"
#include "transport/pack_shading.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

// What a pixel covers on the surface, in texels of the finest level: log2, at least 0. By area: a slanted surface is
// covered in one direction only, which neither is left to alias nor blurred in full.
double rttLevelOf(double distance, double pixel_angle, double cosine, double texel_width);

// The levels that are seen: `blend` of the one after `fine`. Between levels one is enough, and two are blended only about the
// middle of the way: half of the look-ups, and no step that could be seen.
struct RttLevels {
  std::size_t fine = 0;
  float blend = 0;
};
RttLevels rttLevelsAt(double level, std::size_t count);

// Rows t, b, n: local coordinates of a direction in the object. The tangent need be neither unit nor perpendicular.
Eigen::Matrix3d localFrame(const Float3& normal, const formats::Float4& tangent);

// A hit as its patch sees it.
struct SeenPoint {
  std::size_t appearance = 0;
  formats::Triangle corners = {};
  std::array<float, 3> weights = {};
  formats::Float2 texcoord = {0, 0};
  Vec3 to_eye = Vec3::UnitZ();  // local
  double distance = 0;
};
// `frame_weights` of the corners' frames make the local one.
SeenPoint seenPoint(const formats::TriangleMesh& mesh, std::span<const formats::Float4> tangents,
                    const SurfaceHit& hit, const std::array<float, 3>& frame_weights, const Vec3& eye);
std::array<float, 3> cornerWeights(const SurfaceHit& hit);

// The factors of a patch, decoded. The patch may go after construction.
class PatchLookup {
 public:
  // `index` null: by texture coordinates. Throws std::invalid_argument if tables do not fit.
  PatchLookup(const formats::FactoredPatch& patch, const formats::PackImage* index);

  std::size_t components() const { return components_; }
  // components() factors: between the four views around, filtered to what `pixel_angle` covers.
  void factorsAt(const SeenPoint& point, double pixel_angle, std::span<float> factors) const;

  struct View {
    std::size_t view = 0;  // row · views + column of the grid
    float weight = 0;      // they sum to 1; 0 for what is not to be looked up
    formats::Float2 place = {0, 0};
  };
  // The four views about a direction of the patch's frame, each at the place where it sees what is seen at `place` along that
  // direction. What lies h above the mid-plane shows elsewhere in each: where place + h · (slope − the view's slope) is. Its
  // height is found by going down from near the highest in a few steps; a view that then does not see that point (something is in
  // front of it) counts for little. Without heights: all at `place`.
  std::array<View, 4> viewsAt(const formats::RttLevel& level, const formats::Float2& place,
                              const Vec3& to_eye) const;
  const formats::RttLevel& finestLevel() const { return levels_.front(); }

 private:
  formats::Float2 placeOf(const formats::Float2& texcoord) const;
  float heightAt(const formats::RttLevel& level, const formats::Float2& place, std::size_t view) const;
  void add(const formats::RttLevel& level, const View& view, float weight, std::span<float> sum) const;
  std::size_t viewCount() const { return static_cast<std::size_t>(views_) * views_; }

  int views_;
  std::size_t components_;
  double texel_width_, repeats_, aspect_;
  float least_cosine_;
  std::vector<formats::RttLevel> levels_;
  std::vector<float> factors_;
  std::vector<float> heights_;  // in widths; empty without relief
  float highest_ = 0;
  std::vector<formats::Float2> slopes_;  // of views: x/z, y/z
  std::vector<std::uint8_t> index_;      // U, V
  int index_width_ = 0, index_height_ = 0;
  std::array<float, 2> index_scale_ = {1, 1}, index_offset_ = {0, 0};
};

// Players do the same. By measurement (bench_biscale): where steps begin, as a share of the highest, how many they are, and the
// cosine of the flattest direction whose slope is followed (beyond, the surface's own curvature counts for more); what a view
// counts that does not see the point, beside one that does (where none does, all count again).
inline constexpr float kReliefStart = 0.8F;
inline constexpr int kReliefSteps = 3;
inline constexpr float kLeastReliefCosine = 0.2F;
inline constexpr float kUnseenReliefWeight = 1e-3F;

// For a grid of views: kLeastReliefCosine, or that of its own flattest views.
float leastReliefCosine(int views);
// x/z and y/z of a direction, no flatter than that.
formats::Float2 reliefSlope(const Vec3& direction, float least_cosine);

}  // namespace bakelight::transport
