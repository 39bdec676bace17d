#include "tools/simplify/texcoords.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "tools/simplify/simplify.h"

namespace bakelight::simplify {
namespace {

using formats::Float2;
using formats::Float3;
using formats::TriangleMesh;

// A unit cube whose faces form a cross: 4 columns and 3 rows of squares, each face with vertices of its own.
TriangleMesh crossCube() {
  struct Face {
    Float3 origin, across, up;
    int column, row;
  };
  const std::vector<Face> faces = {
      {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1, 1},  {{1, 0, 1}, {0, 0, -1}, {0, 1, 0}, 2, 1},
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, 3, 1}, {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0, 1},
      {{0, 1, 1}, {1, 0, 0}, {0, 0, -1}, 1, 2}, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 1, 0}};
  TriangleMesh mesh;
  for (const Face& face : faces) {
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        Float3 p = face.origin;
        for (std::size_t c = 0; c < 3; ++c)
          p[c] += static_cast<float>(i) * face.across[c] + static_cast<float>(j) * face.up[c];
        mesh.positions.push_back(p);
        mesh.texcoords.push_back(
            {static_cast<float>(face.column + i) / 4, static_cast<float>(face.row + j) / 3});
      }
    mesh.triangles.push_back({first, first + 1, first + 3});
    mesh.triangles.push_back({first, first + 3, first + 2});
  }
  return mesh;
}

// An open cylinder around Y whose seam is at x = 1, z = 0; u runs around it.
TriangleMesh cylinder(std::uint32_t sides) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= sides; ++i)
    for (int end = 0; end < 2; ++end) {
      const double angle = 2 * std::numbers::pi * (i % sides) / sides;
      mesh.positions.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(end),
                                static_cast<float>(-std::sin(angle))});
      mesh.texcoords.push_back({static_cast<float>(i) / static_cast<float>(sides), static_cast<float>(end)});
    }
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t a = 2 * i;
    mesh.triangles.push_back({a, a + 2, a + 3});
    mesh.triangles.push_back({a, a + 3, a + 1});
  }
  return mesh;
}

using CornerSet = std::multiset<std::pair<Float3, Float2>>;

// The corners of each triangle, and all triangles, without regard to order.
std::multiset<CornerSet> cornersOf(const TriangleMesh& mesh) {
  std::multiset<CornerSet> all;
  for (const auto& triangle : mesh.triangles) {
    CornerSet corners;
    for (const std::uint32_t v : triangle) corners.insert({mesh.positions[v], mesh.texcoords[v]});
    all.insert(corners);
  }
  return all;
}

SimplifyOptions keepingAll() {
  SimplifyOptions options;
  options.triangles = 1000;
  return options;
}

void expectSameCorners(const TriangleMesh& input, const TriangleMesh& output) {
  ASSERT_EQ(output.texcoords.size(), output.vertexCount());
  ASSERT_EQ(output.normals.size(), output.vertexCount());
  EXPECT_EQ(cornersOf(output), cornersOf(input));
}

TEST(Texcoords, ACubeKeepsItsCross) {
  const TriangleMesh cube = crossCube();
  const SimplifyResult result = simplify(cube, keepingAll(), "cube.obj");
  expectSameCorners(cube, result.mesh);
  EXPECT_EQ(result.mesh.vertexCount(), 24u);  // creases split all that seams split
  EXPECT_EQ(result.report.seam_vertices, 0);
  // Shaded smoothly, the 8 corners of the cube have the cross's 14 places: 4 squares of a row have 10, those
  // above and below add 2 each.
  SimplifyOptions smooth = keepingAll();
  smooth.crease_angle_deg = 180;
  const SimplifyResult smoothed = simplify(cube, smooth, "cube.obj");
  expectSameCorners(cube, smoothed.mesh);
  EXPECT_EQ(smoothed.mesh.vertexCount(), 14u);
  EXPECT_EQ(smoothed.report.seam_vertices, 6);
}

TEST(Texcoords, ACylinderKeepsItsSeam) {
  const TriangleMesh mesh = cylinder(12);
  const SimplifyResult result = simplify(mesh, keepingAll(), "cylinder.obj");
  EXPECT_EQ(result.report.repairs.welded_vertices, 2);
  EXPECT_EQ(result.report.seam_vertices, 2);
  expectSameCorners(mesh, result.mesh);
  // Copies along the seam have one normal: it does not show.
  std::map<Float3, Float3> normal_at;
  for (std::size_t v = 0; v < result.mesh.vertexCount(); ++v)
    EXPECT_EQ(normal_at.try_emplace(result.mesh.positions[v], result.mesh.normals[v]).first->second,
              result.mesh.normals[v]);
}

TEST(Texcoords, FollowCornersThroughARepair) {
  TriangleMesh mesh = crossCube();
  const TriangleMesh clean = mesh;
  for (const std::size_t t : {1, 4, 9}) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);  // turned
  mesh.triangles.push_back(mesh.triangles[2]);                                                  // twice
  mesh.triangles.push_back({0, 0, 1});                                                          // nothing
  mesh.positions[21][1] += 1e-8f;  // welded to an earlier vertex
  const SimplifyResult result = simplify(mesh, keepingAll(), "cube.obj");
  EXPECT_EQ(result.report.repairs.reoriented_triangles, 3);
  EXPECT_EQ(result.report.repairs.duplicate_triangles, 1);
  expectSameCorners(clean, result.mesh);
}

TEST(Texcoords, AreLeftOutWhereTrianglesChange) {
  // A T-junction closed by a triangle without area: the repair flips it into its neighbour.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, -1, 0}};
  mesh.triangles = {{0, 1, 3}, {0, 2, 1}, {0, 4, 2}, {2, 4, 1}};
  mesh.texcoords.assign(5, {0.5f, 0.5f});
  const SimplifyResult result = simplify(mesh, keepingAll(), "t.obj");
  ASSERT_EQ(result.report.repairs.zero_area_triangles, 1);
  EXPECT_TRUE(result.mesh.texcoords.empty());
  ASSERT_EQ(result.report.warnings.size(), 1u);
  EXPECT_NE(result.report.warnings[0].find("texture coordinates"), std::string::npos);
}

TEST(Texcoords, AreLeftOutByDecimation) {
  SimplifyOptions options;
  options.triangles = 40;
  const SimplifyResult result = simplify(cylinder(64), options, "cylinder.obj");
  EXPECT_TRUE(result.mesh.texcoords.empty());
  EXPECT_TRUE(result.report.warnings.empty());
  const auto& notes = result.report.left_out;
  EXPECT_EQ(std::count_if(notes.begin(), notes.end(),
                          [](const std::string& note) { return note.starts_with("texture coordinates"); }),
            1);
}

TEST(Texcoords, AMeshWithoutAnyIsAsItWas) {
  TriangleMesh with = cylinder(12), without = with;
  without.texcoords.clear();
  const SimplifyResult a = simplify(with, keepingAll(), ""), b = simplify(without, keepingAll(), "");
  EXPECT_TRUE(b.mesh.texcoords.empty());
  EXPECT_EQ(b.report.left_out.size(), 1u);  // decimation
  // Copies follow at the end.
  EXPECT_TRUE(std::equal(b.mesh.positions.begin(), b.mesh.positions.end(), a.mesh.positions.begin()));
}

}  // namespace
}  // namespace bakelight::simplify
