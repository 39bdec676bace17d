#include "tools/simplify/orientation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>

namespace bakelight::simplify {
namespace {

// The three axes as points tell the whole rotation.
formats::TriangleMesh axes() {
  formats::TriangleMesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.normals = mesh.positions;
  return mesh;
}

TEST(Orientation, EachAxisIsRotatedToPlusY) {
  const std::map<std::string, formats::Float3> directions = {{"y", {0, 1, 0}}, {"-y", {0, -1, 0}},
                                                             {"z", {0, 0, 1}}, {"-z", {0, 0, -1}},
                                                             {"x", {1, 0, 0}}, {"-x", {-1, 0, 0}}};
  ASSERT_EQ(std::size(kUpAxes), directions.size());
  for (const auto& [name, direction] : directions) {
    formats::TriangleMesh mesh = axes();
    turnUpright(mesh, *formats::valueFor(kUpAxes, name));
    EXPECT_EQ(mesh.normals, mesh.positions) << name;
    Eigen::Matrix3f rotation;
    for (int c = 0; c < 3; ++c) rotation.col(c) = Eigen::Map<const Eigen::Vector3f>(mesh.positions[c].data());
    EXPECT_EQ(rotation.determinant(), 1) << name;
    EXPECT_EQ(rotation * Eigen::Map<const Eigen::Vector3f>(direction.data()), Eigen::Vector3f(0, 1, 0))
        << name;
  }
}

}  // namespace
}  // namespace bakelight::simplify
