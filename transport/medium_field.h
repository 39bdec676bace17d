// A medium that is another from place to place, and what diffusion through it is taken for: R_d of a uniform medium that has what there is
// along the way.
//
// σ = (1 − m) σ of the medium + m σ of its veins, with a share m of 0 to 1 at each place. Light does not go straight: it spreads about the line between
// two points as far as they are apart. So m of a way is the mean along its line of what is around it, over half of its length. That is a model, exact where m is the
// same everywhere, and as far from the truth as reference's random walk says (docs/TRANSLUCENCY.md).
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

  bool isUniform() const { return levels_.empty(); }
  // Uniform media of some shares between 0 and 1, ascending; of a uniform one just that. Three colors each.
  std::span<const std::array<DiffuseReflectance, 3>> reflectances() const { return reflectances_; }
  // Between two of those: the share of the second of them.
  struct Place {
    std::uint32_t node = 0;
    float share = 0;
  };
  static constexpr std::uint32_t kNodes = 12;
  // Of the way from one point to another, either way. Cost: 2 · 16 lookups; none of a uniform medium.
  Place along(const Vec3& from, const Vec3& to) const {
    return isUniform() ? Place{} : placeOf(shareAlong(from, to));
  }
  static Place placeOf(double share);

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

  Eigen::Isometry3d object_from_here_;
  std::array<ScatteringCoefficients, 3> plain_, veined_;
  std::vector<std::array<DiffuseReflectance, 3>> reflectances_;
  double cell_;
  Vec3 origin_;  // the least corner of the first cell
  std::vector<Level> levels_;
};

}  // namespace bakelight::transport
