// The two steps of VertexShading; what they add up to is in vertex_shading_test.cpp.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <optional>

#include "tests/e2e/made_packs.h"
#include "tests/support/evaluate_pack.h"
#include "tests/support/pack_parts.h"
#include "transport/glossy.h"

namespace bakelight::transport {
namespace {

using formats::Lobe, formats::Storage;

constexpr int kOrder = 4, kRows = 3;
const Vec3 kEye(4, -1, 9), kOtherEye(-2, 3, 4);

formats::Pack packOf(Storage storage, Lobe model) {
  formats::Pack pack = tests::wavyPack(kOrder, 10);
  tests::addGlossyTransfer(pack, kRows, storage);
  reflectionOf(pack) =
      formats::MadeReflection{model, 8, 0.5F, {0.5F, 0.25F, 1}, tests::madeBrdfTable(9, kRows)};
  return pack;
}

ShLight someLight(double phase) {
  ShLight light(coefficientCount(kOrder));
  for (std::size_t i = 0; i < light.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      light[i][c] =
          static_cast<float>(std::sin(phase + 1.7 * static_cast<double>(i) + 0.6 * static_cast<double>(c)));
  return light;
}

std::vector<Float3> seenFrom(VertexShading& shading, const Vec3& eye) {
  shading.setView(eye);
  const std::span<const Float3> radiance = shading.vertexRadiance();
  return {radiance.begin(), radiance.end()};
}

class PackSteps : public testing::TestWithParam<std::tuple<Storage, Lobe>> {
 protected:
  const formats::Pack pack_ = packOf(std::get<0>(GetParam()), std::get<1>(GetParam()));
};

// Light, view, light, view: no step leaves anything behind.
TEST_P(PackSteps, DependOnTheLastLightAndTheLastEyeOnly) {
  VertexShading evaluator(pack_);
  for (const Float3& black : seenFrom(evaluator, kEye)) EXPECT_EQ(black, (Float3{0, 0, 0}));
  evaluator.setLight(someLight(0), someLight(3));
  evaluator.setView(kEye);
  evaluator.setLight(someLight(1), {});
  const std::vector<Float3> first = seenFrom(evaluator, kOtherEye);
  EXPECT_EQ(first, evaluatePack(pack_, someLight(1), {}, kOtherEye));
  EXPECT_EQ(seenFrom(evaluator, kEye), evaluatePack(pack_, someLight(1), {}, kEye));
  EXPECT_NE(first, seenFrom(evaluator, kEye)) << "the view shows";
}

TEST_P(PackSteps, DoNotNeedThePackAndGiveTheSameOnOneThread) {
  std::optional<formats::Pack> pack = pack_;
  VertexShading evaluator(*pack);
  pack.reset();
  evaluator.setLight(someLight(0), someLight(3));
  const std::vector<Float3> many = seenFrom(evaluator, kEye);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, evaluatePack(pack_, someLight(0), someLight(3), kEye));
}

INSTANTIATE_TEST_SUITE_P(Storages, PackSteps,
                         testing::Combine(testing::Values(Storage::kMatrix, Storage::kVisibility,
                                                          Storage::kCpca),
                                          testing::Values(Lobe::kPhong, Lobe::kGgx, Lobe::kTable)),
                         [](const auto& instance) {
                           return std::string(nameOf(std::get<0>(instance.param))) + "_" +
                                  nameOf(std::get<1>(instance.param));
                         });

TEST(VertexShading, RefusesVectorsOfAnotherMesh) {
  formats::Pack pack = tests::wavyPack(kOrder, 10);
  pack.mesh.positions.pop_back();
  EXPECT_THROW(VertexShading evaluator(pack), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
