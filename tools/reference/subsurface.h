// Where light enters a translucent object that leaves it at a point: B(x) = ∫ E(y) R_d(|x − y|) dA(y) over the surface, by
// importance sampling instead of any discretisation (Jensen et al. 2001, equations 1–3 of the translucent paper).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "formats/medium.h"
#include "formats/triangle_mesh.h"
#include "tools/reference/distant_light_sampler.h"
#include "transport/medium_field.h"
#include "transport/ray_scene.h"

namespace bakelight::reference {

using transport::Vec3;

class Subsurface {
 public:
  // Light passes between the triangles of one medium only: those of `of_medium` (1 a triangle; empty: all). `rays` are those of
  // the mesh, and maybe more triangles after its own; both outlive this. The mesh's colors are what the medium reflects, if that is the albedo. A medium that varies stays in the object, to which `object_from_mesh` turns the mesh back.
  Subsurface(const formats::Medium& medium, const formats::TriangleMesh& mesh,
             std::vector<std::uint8_t> of_medium, const transport::RayScene& rays,
             const Eigen::Isometry3d& object_from_mesh = Eigen::Isometry3d::Identity());

  double relativeIor() const { return relative_ior_; }

  struct Entry {
    transport::Hit place;  // on the front
    Rgb weight;            // R_d ÷ density by area
  };
  // One point for the exit at `position`, where the mesh has the color `reflectance`. Half of the points lie on lines at right angles to the surface's normal or tangents, at
  // distances drawn by R_d of a color (King, Kulla, Conty and Fajardo 2013, "BSSRDF Importance Sampling"), of which
  // one of a line's hits is taken by what it sends; half anywhere by area. They are combined by the balance heuristic. Nothing where the line meets
  // nothing. Adds to `rays`.
  std::optional<Entry> sample(const Vec3& position, const Rgb& reflectance, const Vec3& normal, double choice,
                              const std::array<double, 2>& point, double pick, std::uint64_t& rays) const;

 private:
  // A point of the surface.
  struct Place {
    Vec3 position;
    transport::MediumField::Surroundings around;  // set where the field is of the surface
  };
  Place placeAt(const Vec3& position, const Rgb& color) const;
  Place placeOf(const transport::Hit& hit) const;
  // R_d of each color between two points, in 1/area.
  Rgb reflectance(const Place& from, const Place& to) const;

  // Distances by the share of R_d that they enclose.
  struct Profile {
    std::vector<double> radii;            // ascending from 0, of equal shares
    double density(double radius) const;  // by area in a plane
    double radiusOf(double share) const;
  };
  double density(const Vec3& from, const Eigen::Matrix3d& axes, const Vec3& to, const Vec3& normal) const;
  Vec3 normalOf(std::uint32_t triangle) const;
  std::optional<Entry> alongLine(const Place& exit, const Eigen::Matrix3d& axes, int axis, const Vec3& origin,
                                 double pick, std::uint64_t& rays) const;

  const formats::TriangleMesh& mesh_;
  const transport::RayScene& rays_;
  std::vector<std::uint8_t> of_medium_;
  transport::MediumField field_;
  std::vector<Profile>
      profiles_;  // of three colors: of the medium, and of its veins, or of the least and the greatest reflectance
  std::vector<double> cumulative_area_;  // of the triangles of the medium, others have none
  double relative_ior_, extent_;
};

}  // namespace bakelight::reference
