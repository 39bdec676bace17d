#include "formats/mesh_transform.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bakelight::formats {
namespace {

Double3 product(const std::array<Double3, 3>& rows, const Double3& v) {
  Double3 result;
  for (std::size_t i = 0; i < 3; ++i) result[i] = rows[i][0] * v[0] + rows[i][1] * v[1] + rows[i][2] * v[2];
  return result;
}

}  // namespace

bool Transform::isIdentity() const {
  return linear == Transform{}.linear && offset == Transform{}.offset;
}

Double3 Transform::point(const Double3& p) const {
  Double3 result = product(linear, p);
  for (std::size_t i = 0; i < 3; ++i) result[i] += offset[i];
  return result;
}

Transform operator*(const Transform& outer, const Transform& inner) {
  Transform result;
  result.offset = outer.point(inner.offset);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      result.linear[row][column] = 0;
      for (std::size_t k = 0; k < 3; ++k)
        result.linear[row][column] += outer.linear[row][k] * inner.linear[k][column];
    }
  }
  return result;
}

Transform transformOf(const Double3& translation, const std::array<double, 4>& rotation,
                      const Double3& scale) {
  const auto [x, y, z, w] = rotation;
  const double s = 2 / (x * x + y * y + z * z + w * w);
  Transform result;
  result.linear = {{{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
                    {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)},
                    {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)}}};
  for (Double3& row : result.linear) {
    for (std::size_t column = 0; column < 3; ++column) row[column] *= scale[column];
  }
  result.offset = translation;
  return result;
}

NormalTransform::NormalTransform(const Transform& transform) {
  const auto& m = transform.linear;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const std::size_t r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
      linear[row][column] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
    }
  }
  determinant = m[0][0] * linear[0][0] + m[0][1] * linear[0][1] + m[0][2] * linear[0][2];
  if (determinant >= 0) return;
  for (Double3& row : linear) {
    for (double& value : row) value = -value;
  }
}

Double3 NormalTransform::normal(const Double3& n) const {
  return product(linear, n);
}

Float3 rounded(const Double3& value) {
  return {static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2])};
}

Float3 roundedDirection(const Double3& value) {
  const double largest = std::max({std::abs(value[0]), std::abs(value[1]), std::abs(value[2])});
  if (!(largest > 0) || !std::isfinite(largest)) return rounded(value);
  const Double3 v = {value[0] / largest, value[1] / largest, value[2] / largest};
  const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return rounded({v[0] / length, v[1] / length, v[2] / length});
}

bool place(const std::vector<Double3>& positions, const std::vector<Double3>& normals,
           const Transform& world_from_part, MeshPart& part) {
  const bool moved = !world_from_part.isIdentity();
  part.positions.resize(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    part.positions[i] = rounded(moved ? world_from_part.point(positions[i]) : positions[i]);
  }
  const NormalTransform by_normal(world_from_part);
  part.normals.resize(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    part.normals[i] = moved ? roundedDirection(by_normal.normal(normals[i])) : rounded(normals[i]);
  }
  if (by_normal.determinant < 0) turnOver(part.triangles);
  return by_normal.determinant < 0;
}

void turnOver(std::vector<Triangle>& triangles) {
  for (Triangle& triangle : triangles) std::swap(triangle[1], triangle[2]);
}

std::optional<std::size_t> firstNotFinite(const std::vector<Float3>& positions) {
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Float3& p = positions[i];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) return i;
  }
  return std::nullopt;
}

}  // namespace bakelight::formats
