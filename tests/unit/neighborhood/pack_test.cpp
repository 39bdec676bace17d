// Neighborhood transfer in packs and in files of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/compare.h"
#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/pack.h"
#include "formats/part_tensors.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/neighborhood/made_neighborhood.h"
#include "tools/pack/neighborhood_packing.h"

namespace bakelight {
namespace {

using formats::Neighborhood;
using testing::HasSubstr;

Neighborhood madeNeighborhood() {
  const formats::TriangleMesh ball = tests::standingBall(2);
  const neighborhood::Emitted emitted = tests::unshadowedLight(ball, 2, {1, 0.5F, 0});
  Neighborhood both = tests::groundOf(ball, emitted, 8, 1, 64);
  both.volume = tests::volumeOf(ball, emitted, 4, 1, 64).volume;
  return both;
}

formats::Pack packWith(const Neighborhood& neighborhood) {
  formats::Pack pack;
  pack.mesh = tests::standingBall(2);
  formats::ShTransfer transfer;
  transfer.order = 1;
  transfer.vectors = formats::encodeTable(std::vector<float>(pack.mesh.vertexCount(), 0.5F), 1,
                                          formats::Precision::kFloat32, "made", "vectors");
  pack.transfer = transfer;
  pack.neighborhood = neighborhood;
  return pack;
}

TEST(NeighborhoodPack, HoldsGroundAndVolumePlainAndWithDraco) {
  const Neighborhood made = madeNeighborhood();
  for (const bool draco : {false, true}) {
    const formats::Pack read =
        formats::decodePack(formats::encodePack(packWith(made), {.draco = draco}, "a.glb"), "a.glb");
    ASSERT_TRUE(read.neighborhood);
    const auto* part = read.neighborhood->as<Neighborhood>();
    ASSERT_NE(part, nullptr);
    EXPECT_EQ(part->order, 2);
    EXPECT_EQ(part->channels, 3);
    EXPECT_EQ(part->ground->x, made.ground->x);
    EXPECT_EQ(part->ground->vectors.decode(), made.ground->vectors.decode());
    EXPECT_EQ(part->volume->axes, made.volume->axes);
    EXPECT_EQ(part->volume->matrices.decode(), made.volume->matrices.decode());
  }
}

TEST(NeighborhoodPack, WithoutOneHasNone) {
  formats::Pack pack = packWith(madeNeighborhood());
  pack.neighborhood.reset();
  EXPECT_FALSE(formats::decodePack(formats::encodePack(pack, {}, "a.glb"), "a.glb").neighborhood);
}

TEST(NeighborhoodPack, IsComparedFieldByField) {
  const Neighborhood made = madeNeighborhood();
  const formats::Pack pack = packWith(made);
  EXPECT_TRUE(formats::comparePacks(pack, pack, {}).passes());
  Neighborhood other = made;
  std::vector<float> vectors = other.ground->vectors.decode();
  vectors[100] += 0.25F;
  other.ground->vectors = formats::encodeTable(vectors, other.ground->vectors.columns,
                                               formats::Precision::kFloat32, "made", "vectors");
  EXPECT_FALSE(formats::comparePacks(packWith(other), pack, {}).passes());
  formats::Pack without = pack;
  without.neighborhood.reset();
  EXPECT_FALSE(formats::comparePacks(without, pack, {}).passes());
}

TEST(NeighborhoodPack, ThatBreaksARuleIsRefusedByItsName) {
  const auto refusal = [](auto spoil) -> std::string {
    Neighborhood part = madeNeighborhood();
    spoil(part);
    try {
      formats::encodePack(packWith(part), {}, "a.glb");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal([](Neighborhood&) {}), "");
  EXPECT_THAT(refusal([](Neighborhood& n) { std::swap(n.ground->x[0], n.ground->x[1]); }),
              HasSubstr("do not rise"));
  EXPECT_THAT(refusal([](Neighborhood& n) { n.ground->z.pop_back(); }), HasSubstr("groundVectors"));
  EXPECT_THAT(refusal([](Neighborhood& n) { n.volume->axes[1].push_back(100); }),
              HasSubstr("volumeMatrices"));
  EXPECT_THAT(refusal([](Neighborhood& n) { n.ground.reset(), n.volume.reset(); }),
              HasSubstr("neither ground nor volume"));
}

TEST(NeighborhoodFile, IsReadAsItWasWritten) {
  const Neighborhood made = madeNeighborhood();
  formats::PackPart part(made), read{Neighborhood()};
  formats::readPart(read, formats::tensorsOf(part), "made");
  const auto* found = read.as<Neighborhood>();
  EXPECT_EQ(found->ground->level, made.ground->level);
  EXPECT_EQ(found->ground->vectors.decode(), made.ground->vectors.decode());
  EXPECT_EQ(found->volume->axes, made.volume->axes);
}

TEST(NeighborhoodPacking, TellsWhatThePrecisionCosts) {
  const tests::TemporaryFolder folder;
  const formats::TriangleMesh ball = tests::standingBall(2);
  const Neighborhood made = madeNeighborhood();
  formats::PackPart part(made);
  formats::TensorFile file = formats::tensorsOf(part);
  file.metadata["mesh_hash"] = formats::geometryHash(ball);
  formats::writeSafetensors(folder / "n.safetensors", file);
  const auto packed = [&](formats::Precision precision, const formats::TriangleMesh& mesh) {
    return packing::readNeighborhood(folder / "n.safetensors", mesh, "mesh.ply", precision);
  };
  EXPECT_EQ(packed(formats::Precision::kFloat32, ball).errors.at("ground"), 0);
  const packing::PackedNeighborhood halves = packed(formats::Precision::kFloat16, ball);
  EXPECT_EQ(halves.part.ground->vectors.precision, formats::Precision::kFloat16);
  EXPECT_EQ(halves.part.volume->matrices.precision, formats::Precision::kFloat16);
  for (const auto& [name, error] : halves.errors) {
    EXPECT_GT(error, 1e-5) << name;
    EXPECT_LT(error, 5e-4) << name;
  }
  EXPECT_GT(packed(formats::Precision::kUint8, ball).errors.at("volume"), 1e-3);
  try {
    packed(formats::Precision::kFloat16, tests::standingBall(1));
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("mesh.ply"), HasSubstr("mesh_hash")));
  }
}

}  // namespace
}  // namespace bakelight
