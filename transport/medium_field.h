// A medium that is another from place to place, and what diffusion through it is taken for: R_d of a uniform medium that has what there is
// along the way.
//
// σ = (1 − m) σ of the medium + m σ of its veins, with a share m of 0 to 1 at each place. Light does not go straight: it spreads about the line between
// two points as far as they are apart. So m of a way is the mean along its line of what is around it, over half of its length. That is a model, exact where m is the
// same everywhere, and as far from the truth as reference's random walk says (docs/TRANSLUCENCY.md).
//
// Where the surface's albedo is the reflectance instead, σt′ is the same everywhere, and R_d that of the α′ at which a half space reflects, of each color, the mean
// of what the two ends do (coefficientsOfReflectance). An end is what is around it, over about half as much as the two are apart: light that comes from afar has
// been through more than the grain it leaves at.
#pragma once

#include <array>
#include <cstdint>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "formats/medium.h"
#include "formats/triangle_mesh.h"
#include "transport/diffusion.h"
#include "transport/vector_types.h"

namespace bakelight::transport {

using formats::Float3;

class MediumField {
 public:
  // Of an object with those vertices; lengths in the asset's unit. Veins stay where they are in the object: `object_from_here` turns and moves
  // the vertices, and all points that are asked for, to their places as the asset has them. Throws std::invalid_argument for coefficients as DiffuseReflectance does,
  // and for veins that are too thin against the object: less than some 1/100 of it, or more cells than kMostCells.
  MediumField(const formats::Medium& medium, std::span<const Float3> positions,
              const Eigen::Isometry3d& object_from_here = Eigen::Isometry3d::Identity());

  // The same; where the medium's reflectance is the albedo, that is the mesh's colors, of the vertices that triangles have. Throws std::invalid_argument, too, for
  // one of them that is not finite, or none.
  MediumField(const formats::Medium& medium, const formats::TriangleMesh& mesh,
              const Eigen::Isometry3d& object_from_here = Eigen::Isometry3d::Identity());

  bool isUniform() const { return reflectances_.size() == 1; }
  // Whether ways have what is at their ends, each color its own; not where all vertices have the same.
  bool isOfSurface() const { return !isUniform() && levels_.empty(); }
  // Uniform media of some shares between 0 and 1, ascending, or of reflectances from the least to the greatest that there is; of a uniform one just that. Three colors each.
  std::span<const std::array<DiffuseReflectance, 3>> reflectances() const { return reflectances_; }
  // Between two of those, of each color: the share of the second of them. The same of all colors unless isOfSurface().
  struct Place {
    std::array<std::uint32_t, 3> node = {0, 0, 0};
    std::array<float, 3> share = {0, 0, 0};
    static Place at(std::uint32_t node) { return {{node, node, node}}; }
  };
  static constexpr std::uint32_t kNodes = 12;
  // Of the way from one point to another, either way, unless isOfSurface(). Cost: 2 · 16 lookups; none of a uniform medium.
  Place along(const Vec3& from, const Vec3& to) const {
    return isUniform() ? Place{} : placeOf(shareAlong(from, to));
  }
  static Place placeOf(double share);

  // What is reflected at a point of the surface, and means around it, each over cells of twice the last one's side, the first of which have 1/128 of the object.
  static constexpr std::size_t kScales = 9;
  using Surroundings = std::array<Eigen::Array3f, kScales>;
  Surroundings surroundings(const Vec3& point, const Float3& reflectance) const;
  // If isOfSurface(): of the way between two points with those surroundings, so far apart.
  Place along(const Surroundings& from, const Surroundings& to, double distance) const;
  // Between them R_d is linear in the reflectance, so totals are right. Elsewhere it errs by 1 % of the total at most, all distances together.
  static constexpr std::uint32_t kReflectanceNodes = 40;
  // Reflectances below it count as this, and those above 1 as 1.
  static constexpr float kLeastReflectance = 1e-3F;

  // R_d of a color over that distance of such a way; not at 0 for normalized diffusion.
  double reflectance(std::size_t color, double distance, const Place& place) const;
  // m at a point, and the coefficients there, per unit of length.
  double shareAt(const Vec3& point) const;
  ScatteringCoefficients coefficients(std::size_t color, double share) const;
  // Side of the cells between which m is linear; infinite for a uniform medium.
  double cell() const { return cell_; }

  static constexpr std::size_t kMostCells = std::size_t{1} << 25;

 private:
  // Means over cubes, rows of x first; the finest level first, each next of twice its cells.
  struct Level {
    std::array<int, 3> size = {0, 0, 0};
    std::vector<float> shares;
  };
  double shareAlong(const Vec3& from, const Vec3& to) const;
  double sample(std::size_t level, const Vec3& point) const;
  // As Level, of the surface.
  struct SurfaceLevel {
    std::array<int, 3> size = {0, 0, 0};
    std::vector<Eigen::Array4f> sums;  // reflectance × area, area
  };
  void addUp(const formats::TriangleMesh& mesh, std::span<const Eigen::Array3f> reflectance);

  Eigen::Isometry3d object_from_here_;
  std::array<ScatteringCoefficients, 3> plain_, veined_;
  std::vector<std::array<DiffuseReflectance, 3>> reflectances_;
  double cell_;
  Vec3 origin_;  // the least corner of the first cell
  std::vector<Level> levels_;

  static constexpr std::uint32_t kReflectanceBins = 64;
  struct ColorNodes {
    std::array<float, kReflectanceNodes> reflectances = {};
    std::array<std::uint32_t, kReflectanceBins> of_bin = {};  // of its least reflectance, even from 0 to 1
  };
  std::array<ColorNodes, 3> color_nodes_;
  double surface_cell_ = 0;
  std::vector<SurfaceLevel> surface_levels_;
};

}  // namespace bakelight::transport
