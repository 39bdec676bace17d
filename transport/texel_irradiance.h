// What punctual lights send into a translucent object, at each texel of its atlas, in the shadow of the object itself.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/translucency.h"
#include "transport/pack_shading.h"

namespace bakelight::transport {

// Where texels lie on the surface.
class TexelIrradiance {
 public:
  // A mesh with normals and texture coordinates, of which the translucency has the knots. Throws std::invalid_argument if a texel's knots
  // are no triangle of it.
  TexelIrradiance(const formats::Translucency& translucency, const formats::TriangleMesh& mesh);

  // Mean over each texel of irradiance × Schlick's transmittance, in the order of Translucency::texels. Cosines are those of
  // interpolated normals; rays start where they would from a smooth surface through the vertices (smoothPoint), so that no triangle
  // shadows itself where the surface turns away from the light, nor is lit from behind. Where a texel's corners agree in shadow,
  // and within a tenth in what they would get if they faced the light, it has their mean; others, which an edge of light goes
  // through, that of kPlaces places. Cost: 4 or 4 + kPlaces
  // rays for each light. On all TBB threads, same bytes for any number.
  std::vector<Float3> entering(std::span<const PlacedPunctualLight> lights, const Occlusion& occluded) const;
  static constexpr std::size_t kPlaces = 16;

  // For those who do the same elsewhere.
  struct Texel {
    std::uint32_t triangle;
    float u, v;  // of its middle: weights of the second and third corner
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  // Across the edge opposite of a corner: a triangle, and its corner off that edge. Corners that follow this one are those before
  // that one.
  struct Neighbour {
    std::uint32_t triangle = kNone;
    std::uint32_t corner = 0;
  };
  struct Surroundings {
    std::array<Neighbour, 3> neighbours;
    std::array<double, 2> across{}, down{};  // how u and v change by a step of a texel
  };
  std::span<const Texel> texels() const { return texels_; }
  std::span<const Surroundings> triangles() const { return triangles_; }
  double offset() const { return offset_; }  // of rays, off the surface

 private:
  // From outside of a triangle into its neighbours, as if they were unfolded into its plane; as far as the surface goes.
  void walk(std::uint32_t& triangle, double& u, double& v) const;

  const formats::TriangleMesh& mesh_;
  double eta_, offset_;
  std::vector<Texel> texels_;
  std::vector<Surroundings> triangles_;
};

}  // namespace bakelight::transport
