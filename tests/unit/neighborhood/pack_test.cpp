// Neighborhood transfer in packs and in files of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/compare.h"
#include "formats/error.h"
#include "formats/pack.h"
#include "formats/part_tensors.h"
#include "tests/unit/neighborhood/made_neighborhood.h"

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

}  // namespace
}  // namespace bakelight
