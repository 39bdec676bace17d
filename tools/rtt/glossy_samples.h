// Where a glossy surface takes light from that it sends towards a view.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "formats/material.h"
#include "transport/microfacet.h"
#include "transport/vector_types.h"

namespace bakelight::rtt {

using transport::Vec3;

struct GlossySample {
  Vec3 incoming;  // unit, above the surface
  Vec3 weight;  // RGB: radiance towards the view is the mean over the samples of weight · radiance from there
};

// Of a material's reflection without its diffuse part: Phong's lobe around the mirror direction, microfacets, a mirror,
// or a table of the tool brdf.
class GlossyReflection {
 public:
  explicit GlossyReflection(const formats::Reflection& reflection);

  bool isNone() const { return std::holds_alternative<std::monostate>(kind_); }
  // The samples that one look takes: 1 of a mirror, else `wanted` rounded up to whole batches of 16.
  int sampleCount(int wanted) const;
  // So many are appended, fewer where directions fall below the surface: their light is lost, as weights are of all.
  // `view` is unit and is taken to be above the surface. `element`: tells one look from another.
  void sample(const Vec3& normal, const Vec3& view, int count, std::uint64_t element,
              std::vector<GlossySample>& samples) const;

 private:
  struct Phong {
    Vec3 color;
    double exponent;
  };
  std::variant<std::monostate, Phong, transport::Microfacets, formats::BrdfTable> kind_;
};

}  // namespace bakelight::rtt
