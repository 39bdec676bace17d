// Light inside a translucent object as it is: walks of photons through the medium that the mesh encloses, from where light leaves it
// towards the eye to where it came in. No diffusion, no half space, no straight distances: the truth that diffusion is held against.
//
// Where the medium has veins, its coefficients are those of the place, taken as constant over half a cell of transport/medium_field.h on each
// flight. By the similarity relation it scatters isotropically with σs′ (van de Hulst 1980, section 14.1). Its boundary is smooth
// inside: Fresnel's reflectance, total beyond the critical angle, and Snell's law where the eye looks in. Light from outside goes in
// diffusely: E · T(θ) of Fresnel's transmittance, spread inside as uniform light would be, radiance ∝ T(θ) T_inside(μ). That is
// reciprocal, loses nothing, is exact under uniform light, and lets lights of any size, suns too, be sampled at the boundary, which no
// refracted ray through the interior could.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "formats/medium.h"
#include "formats/triangle_mesh.h"
#include "tools/reference/distant_light_sampler.h"
#include "tools/reference/trace_counts.h"
#include "transport/medium_field.h"
#include "transport/ray_scene.h"

namespace bakelight::reference {

using transport::Vec3;

class RandomWalk {
 public:
  // The medium fills the bodies that the mesh encloses, where they overlap once. Light passes through triangles of `of_medium` (1 a
  // triangle; empty: all); others absorb what meets them from inside. `rays` are those of the mesh, and maybe more triangles after its own; both outlive this. A medium that varies stays in the object, to which `object_from_mesh` turns the mesh back.
  RandomWalk(const formats::Medium& medium, const formats::TriangleMesh& mesh,
             std::vector<std::uint8_t> of_medium, const transport::RayScene& rays,
             const Eigen::Isometry3d& object_from_mesh = Eigen::Isometry3d::Identity());

  double relativeIor() const { return relative_ior_; }
  // ∫ T(θ) cos θ dω ÷ π: what of uniform light enters.
  double diffuseTransmittance() const { return diffuse_transmittance_; }

  static constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();
  struct Start {
    Vec3 position;                         // on the surface
    Vec3 normal;                           // for shading, on the side that is looked at
    std::uint32_t triangle = kNoTriangle;  // that it lies in; none at a vertex
    bool back_face = false;                // the triangle's clockwise side is looked at
  };
  // Looking from `towards_eye` (unit, above the surface) by Snell's law; below the triangle even if the normal for shading would have it
  // otherwise.
  Vec3 refracted(const Start& start, const Vec3& towards_eye) const;

  struct Exit {
    transport::Hit place;  // seen from outside, at the distance of the last segment
    Rgb weight;            // ≥ 0, of mean ≤ 1
  };
  // One walk from below the surface into `direction`, to where it leaves; nothing where it is absorbed or lost. All colors take one
  // walk: each flight's length is drawn by one of them, chosen by its share of the weight, and weighed by all
  // (balance heuristic, Wilkie et al. 2014, "Hero Wavelength Spectral Sampling"), so that the weights' sum never grows. Russian roulette begins when
  // a quarter of it is left. A walk has kMostEvents at most: places where it scatters or meets a triangle. Adds to `counts`.
  std::optional<Exit> walk(const Start& start, const Vec3& direction, std::uint64_t seed,
                           TraceCounts& counts) const;
  static constexpr int kMostEvents = 1 << 20;

 private:
  struct Boundary {
    double distance;
    transport::Hit hit;
  };
  struct Segment {
    Vec3 origin, direction;
    double length;        // drawn
    double least;         // what is nearer counts as the place that it begins at
    std::uint32_t begun;  // the triangle that it begins on
  };
  std::optional<Boundary> boundaryOn(const Segment& segment, TraceCounts& counts) const;
  // The next on the segment's line from that distance on, which goes past it.
  std::optional<Boundary> nextOn(const Segment& segment, float& from, TraceCounts& counts) const;
  // How many bodies the segment's line leaves more often than it enters them: the place is in so many; below 0 if they are inside out.
  int windingAhead(const Segment& segment, TraceCounts& counts) const;
  bool withinBounds(const Vec3& position) const;
  // From its origin: how far light of a color goes until that optical depth, and what depth each color has after a length.
  double lengthOf(const Segment& segment, Eigen::Index color, double depth) const;
  Rgb depthOf(const Segment& segment, double length) const;
  Vec3 lastMiddle(const Segment& segment, double length) const;
  Rgb extinctionAt(const Vec3& position) const;
  Rgb scatteringAt(const Vec3& position) const;
  Vec3 cornerOf(std::uint32_t triangle, std::size_t corner) const;
  Vec3 crossOf(std::uint32_t triangle) const;

  const formats::TriangleMesh& mesh_;
  const transport::RayScene& rays_;
  std::vector<std::uint8_t> of_medium_;
  transport::MediumField field_;
  double relative_ior_, diffuse_transmittance_;
  Vec3 lowest_, highest_;  // of the mesh
  double slack_;           // how far behind segments rays begin
};

}  // namespace bakelight::reference
