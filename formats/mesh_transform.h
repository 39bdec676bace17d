// Placing the parts of a mesh by the transforms of their nodes. Private to the importers.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "formats/mesh_parts.h"

namespace bakelight::formats {

using Double3 = std::array<double, 3>;

// Affine, in double: a chain of node transforms must not cost float bits.
struct Transform {
  std::array<Double3, 3> linear = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // rows
  Double3 offset = {0, 0, 0};

  bool isIdentity() const;
  Double3 point(const Double3& p) const;
};

Transform operator*(const Transform& outer, const Transform& inner);

// Scale, then rotation, then translation. The quaternion (x, y, z, w) may have any length but 0.
Transform transformOf(const Double3& translation, const std::array<double, 4>& rotation,
                      const Double3& scale);

// Carries normals, up to length, mirrored or not: the cofactors of the linear part, times the sign of its
// determinant. A mirroring transform turns triangles over (place turns them back), so normals keep their
// side.
struct NormalTransform {
  std::array<Double3, 3> linear;
  double determinant;

  explicit NormalTransform(const Transform& transform);
  Double3 normal(const Double3& n) const;
};

// The nearest floats. Values beyond the range become infinite.
Float3 rounded(const Double3& value);
// As rounded, scaled to unit length first, where it has a direction: a normal's length may fit no float.
Float3 roundedDirection(const Double3& value);

// `positions` and `normals` (as many, or none), transformed and rounded once, become those of `part`; its
// triangles are turned over if the transform mirrors. Returns whether it does.
bool place(const std::vector<Double3>& positions, const std::vector<Double3>& normals,
           const Transform& world_from_part, MeshPart& part);

void turnOver(std::vector<Triangle>& triangles);

// The first vertex whose position is not finite.
std::optional<std::size_t> firstNotFinite(const std::vector<Float3>& positions);

}  // namespace bakelight::formats
