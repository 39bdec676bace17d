// A factored patch (formats/factored_patch.h), decoded to be looked up: which place of the patch a point of the
// surface shows, where there each of the views about the eye's direction sees it, and the factors.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/factored_patch.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

class PatchTable {
 public:
  // `image`: the index, or null. Throws std::invalid_argument if tables do not fit their sizes.
  PatchTable(const formats::FactoredPatch& source, const formats::PackImage* image);

  std::size_t componentCount() const { return components_; }
  float texelWidth() const { return texel_width_; }  // of the finest level, on the surface
  const std::vector<formats::RttLevel>& levels() const { return levels_; }

  // 0–1, u to the right and v upwards; by the index, or by texture coordinates.
  formats::Float2 placeOf(const formats::Float2& texcoord) const;

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

  // Adds `weight` times the factors of the nearest texel towards a view. `sum` has a value a component.
  void add(const formats::RttLevel& level, const View& view, float weight, std::span<float> sum) const;

 private:
  float heightAt(const formats::RttLevel& level, const formats::Float2& place, std::size_t view) const;
  std::size_t viewCount() const { return static_cast<std::size_t>(views_) * views_; }

  int views_;  // a side of the grid
  std::size_t components_;
  float texel_width_, aspect_, repeats_, least_cosine_;
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
