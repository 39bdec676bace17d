#include "tools/pack/packing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/error.h"
#include "formats/mesh_ply.h"

namespace bakelight::packing {
namespace {

using testing::AllOf;
using testing::HasSubstr;

formats::TriangleMesh triangle() {
  formats::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

formats::TensorFile transferFor(const formats::TriangleMesh& mesh) {
  std::vector<float> values(mesh.vertexCount() * 4);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  formats::TensorFile file;
  file.tensors["transfer"] =
      formats::Tensor::from<float>(formats::ElementType::kFloat32, {mesh.vertexCount(), 4}, values);
  file.metadata = {{"technique", "diffuse_vector"},
                   {"order", "2"},
                   {"visibility", "shadowed"},
                   {"basis", "real_sh_cartesian"},
                   {"frame", "object"},
                   {"albedo", "outside"},
                   {"inverse_pi", "inside"},
                   {"mesh_hash", formats::geometryHash(mesh)}};
  return file;
}

std::string errorOf(const formats::TriangleMesh& mesh, const formats::TensorFile& transfer) {
  try {
    assemblePack(mesh, transfer, "a", {0.5F, 0.5F, 0.5F}, {"m.ply", "t.safetensors"});
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Packing, KeepsMeshTableAndAlbedo) {
  const formats::TriangleMesh mesh = triangle();
  const formats::Pack pack =
      assemblePack(mesh, transferFor(mesh), "name", {0.1F, 0.2F, 0.3F}, {"m.ply", "t.safetensors"});
  EXPECT_EQ(pack.name, "name");
  EXPECT_EQ(pack.base_color, (formats::Float3{0.1F, 0.2F, 0.3F}));
  EXPECT_EQ(pack.mesh.positions, mesh.positions);
  EXPECT_EQ(pack.transfer.order, 2);
  EXPECT_EQ(pack.transfer.visibility, "shadowed");
  ASSERT_EQ(pack.transfer.vectors.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(pack.transfer.vectors[i], static_cast<float>(i));
}

TEST(Packing, RefusesATransferOfAnotherMesh) {
  const formats::TensorFile transfer = transferFor(triangle());
  formats::TriangleMesh other = triangle();
  other.positions[1][0] = 1.0000001F;
  EXPECT_THAT(errorOf(other, transfer),
              AllOf(HasSubstr("t.safetensors"), HasSubstr("another mesh than m.ply")));
  other.positions.push_back({1, 1, 1});
  EXPECT_THAT(errorOf(other, transfer), AllOf(HasSubstr("3 × 4"), HasSubstr("4 × 4")));
}

TEST(Packing, RefusesWhatAPackCannotHold) {
  const formats::TriangleMesh mesh = triangle();
  for (const char* key : {"technique", "basis", "frame", "albedo", "inverse_pi", "order"}) {
    formats::TensorFile transfer = transferFor(mesh);
    transfer.metadata[key] = "other";
    EXPECT_THAT(errorOf(mesh, transfer), AllOf(HasSubstr(key), HasSubstr("'other'"))) << key;
    transfer.metadata.erase(key);
    EXPECT_THAT(errorOf(mesh, transfer), HasSubstr(key)) << key;
  }
}

TEST(Packing, BitsAreZeroOrInRange) {
  EXPECT_NO_THROW(checkOptions({.draco = true, .position_bits = 0, .normal_bits = 0}));
  EXPECT_NO_THROW(checkOptions({.draco = true, .position_bits = 8, .normal_bits = 30}));
  EXPECT_THROW(checkOptions({.draco = true, .position_bits = 7}), Error);
  EXPECT_THROW(checkOptions({.draco = true, .normal_bits = 5}), Error);
}

}  // namespace
}  // namespace bakelight::packing
