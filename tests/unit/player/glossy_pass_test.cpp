#include "tools/player/techniques/glossy_pass.h"

#include <cmath>

#include "tests/e2e/made_packs.h"
#include "tests/unit/player/random_values.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/operators/visibility_operator.h"
#include "transport/glossy.h"

namespace bakelight::player {
namespace {

using formats::Lobe;
using formats::Storage;
using transport::Float3;
using transport::Vec3;

// A ball of unit spheres' frames whose matrices nobody reads.
formats::Pack packWith(int row_order, const formats::MadeReflection& material) {
  formats::Pack pack = tests::spherePack(2, 8);
  tests::addGlossyTransfer(pack, row_order, Storage::kVisibility);
  reflectionOf(pack) = material;
  return pack;
}

Vec3 localEye(const formats::Pack& pack, std::size_t v, const Vec3& eye, Eigen::Matrix3d& frame) {
  const Vec3 normal = transport::vec3(pack.mesh.normals[v]);
  const auto& t = pack.sh().glossy->tangents[v];
  const Vec3 tangent(t[0], t[1], t[2]);
  frame << tangent, t[3] * normal.cross(tangent), normal;
  return frame.transpose() * (eye - transport::vec3(pack.mesh.positions[v])).normalized();
}

// Rows (one, or three of a table) in the frame of the transferred radiance.
std::vector<double> expectedRows(const formats::Pack& pack, std::size_t v, const Vec3& eye,
                                 const formats::MadeReflection& material, bool object_frame) {
  const int order = pack.sh().glossy->output_order;
  const std::size_t count = static_cast<std::size_t>(transport::coefficientCount(order));
  Eigen::Matrix3d frame;
  const Vec3 local = localEye(pack, v, eye, frame);
  std::vector<double> rows(3 * count);
  if (material.model == Lobe::kTable) {
    transport::tableRows(material.table, local, order, rows);
    return rows;
  }
  const auto kernel = material.model == Lobe::kPhong ? transport::phongKernel(order, material.exponent)
                                                     : transport::ggxKernel(order, material.roughness);
  std::vector<double> row(count);
  if (object_frame) {
    transport::evaluateSh(order, frame * Vec3(-local.x(), -local.y(), std::abs(local.z())), row);
    for (int l = 0; l < order; ++l)
      for (int m = -l; m <= l; ++m) row[transport::coefficientIndex(l, m)] *= kernel[l];
  } else {
    transport::lobeRow(kernel, local, row);
  }
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < count; ++i) rows[c * count + i] = material.specular_color[c] * row[i];
  return rows;
}

// Random transferred radiance over a diffuse part of `kDiffuse`; how far vertices are off, at most.
double largestError(const formats::MadeReflection& material, int row_order, const Vec3& eye,
                    bool object_frame) {
  const formats::Pack pack = packWith(row_order, material);
  constexpr float kDiffuse = 0.25f;
  const std::size_t n = pack.mesh.vertexCount();
  const std::size_t count =
      static_cast<std::size_t>(transport::coefficientCount(pack.sh().glossy->output_order));
  const auto transferred = randomValues(n * count * 3, 9);
  const std::vector<float> diffuse(3 * n, kDiffuse);
  const SurfaceMesh mesh(pack.mesh, Vec3(0.5, -0.25, 0.125));
  const GlossyPass pass(pack, mesh, object_frame);
  pass.evaluate(eye, makeBuffer(transferred.size() * sizeof(float), transferred.data()),
                makeBuffer(diffuse.size() * sizeof(float), diffuse.data()));
  std::vector<Float3> actual(n);
  glGetNamedBufferSubData(pass.buffer().name(), 0, static_cast<GLsizeiptr>(n * sizeof(Float3)),
                          actual.data());

  double largest = 0;
  for (std::size_t v = 0; v < n; ++v) {
    const auto rows = expectedRows(pack, v, eye, material, object_frame);
    for (std::size_t c = 0; c < 3; ++c) {
      double expected = kDiffuse;
      for (std::size_t i = 0; i < count; ++i)
        expected += rows[c * count + i] * static_cast<double>(transferred[(v * count + i) * 3 + c]);
      largest = std::max(largest, std::abs(actual[v][c] - expected));
    }
  }
  return largest;
}

class GlossyPassTest : public testing::Test {
 protected:
  HeadlessContext context_;
  // Far away; over a pole, along the normal there; and inside the ball, below all surfaces.
  const std::vector<Vec3> eyes_ = {{3, 2, 4}, {0, 5, 0}, {0.1, -0.2, 0.05}};
};

TEST_F(GlossyPassTest, LobesAreThoseOfTransportForEachOrder) {
  for (int order = 1; order <= 10; ++order)
    for (const Vec3& eye : eyes_)
      for (const bool object_frame : {false, true}) {
        formats::MadeReflection material;
        material.model = order % 2 == 0 ? Lobe::kPhong : Lobe::kGgx;
        material.exponent = 40;
        material.roughness = 0.3f;
        material.specular_color = {0.5f, 0.7f, 1};
        EXPECT_LT(largestError(material, order, eye, object_frame), 2e-4)
            << order << ' ' << object_frame << ", eye " << eye.transpose();
      }
}

TEST_F(GlossyPassTest, TablesAreThoseOfTransport) {
  for (const auto& [angles, table_order, row_order] :
       {std::array{1, 3, 3}, std::array{2, 4, 3}, std::array{17, 5, 5}, std::array{64, 10, 9}})
    for (const Vec3& eye : eyes_) {
      formats::MadeReflection material;
      material.model = Lobe::kTable;
      material.table = tests::madeBrdfTable(angles, table_order);
      EXPECT_LT(largestError(material, row_order, eye, false), 2e-4)
          << angles << " angles, eye " << eye.transpose();
    }
}

TEST_F(GlossyPassTest, VisibilityExpandsToMatricesInTheLocalFrame) {
  formats::Pack matrices = tests::spherePack(4, 8), visibility = matrices;
  tests::addGlossyTransfer(matrices, 3, Storage::kMatrix);
  tests::addGlossyTransfer(visibility, 3, Storage::kVisibility);
  const auto expanded = matricesFromVisibility(visibility);
  EXPECT_EQ(storageOf(expanded), Storage::kMatrix);
  const auto expected = matrices.sh().glossy->vertexTable().decode(),
             actual = expanded.glossy->vertexTable().decode();
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) ASSERT_NEAR(actual[i], expected[i], 1e-5) << i;
}

TEST_F(GlossyPassTest, WithoutFramesThereIsNoPass) {
  formats::MadeReflection material;
  material.model = Lobe::kPhong;
  formats::Pack pack = packWith(3, material);
  pack.sh().glossy->tangents.pop_back();
  EXPECT_THROW(GlossyPass(pack, SurfaceMesh(pack.mesh, Vec3::Zero()), false), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::player
