// The two steps of PackEvaluator; what they add up to is in pack_evaluator_test.cpp.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <optional>

#include "tests/e2e/made_packs.h"
#include "transport/glossy.h"
#include "transport/pack_evaluator.h"

namespace bakelight::transport {
namespace {

using formats::LobeModel, formats::MatrixStorage;

constexpr int kOrder = 4, kRows = 3;
const Vec3 kEye(4, -1, 9), kOtherEye(-2, 3, 4);

formats::Pack packOf(MatrixStorage storage, LobeModel model) {
  formats::Pack pack = tests::wavyPack(kOrder, 10);
  tests::addGlossyTransfer(pack, kRows, storage);
  pack.transfer.material.model = model;
  pack.transfer.material.exponent = 8;
  pack.transfer.material.roughness = 0.5F;
  pack.transfer.material.specular_color = {0.5F, 0.25F, 1};
  if (model == LobeModel::kTable) pack.transfer.material.table = tests::madeBrdfTable(9, kRows);
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

std::vector<Float3> copyOf(std::span<const Float3> radiance) {
  return {radiance.begin(), radiance.end()};
}

class PackSteps : public testing::TestWithParam<std::tuple<MatrixStorage, LobeModel>> {
 protected:
  const formats::Pack pack_ = packOf(std::get<0>(GetParam()), std::get<1>(GetParam()));
};

// Light, view, light, view: no step leaves anything behind.
TEST_P(PackSteps, DependOnTheLastLightAndTheLastEyeOnly) {
  PackEvaluator evaluator(pack_);
  for (const Float3& black : copyOf(evaluator.radianceTowards(kEye))) EXPECT_EQ(black, (Float3{0, 0, 0}));
  evaluator.setLight(someLight(0), someLight(3));
  evaluator.radianceTowards(kEye);
  evaluator.setLight(someLight(1), {});
  const std::vector<Float3> first = copyOf(evaluator.radianceTowards(kOtherEye));
  EXPECT_EQ(first, evaluatePack(pack_, someLight(1), {}, kOtherEye));
  EXPECT_EQ(copyOf(evaluator.radianceTowards(kEye)), evaluatePack(pack_, someLight(1), {}, kEye));
  EXPECT_NE(first, copyOf(evaluator.radianceTowards(kEye))) << "the view shows";
}

TEST_P(PackSteps, DoNotNeedThePackAndGiveTheSameOnOneThread) {
  std::optional<formats::Pack> pack = pack_;
  PackEvaluator evaluator(*pack);
  pack.reset();
  evaluator.setLight(someLight(0), someLight(3));
  const std::vector<Float3> many = copyOf(evaluator.radianceTowards(kEye));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many, evaluatePack(pack_, someLight(0), someLight(3), kEye));
}

INSTANTIATE_TEST_SUITE_P(Storages, PackSteps,
                         testing::Combine(testing::Values(MatrixStorage::kMatrix, MatrixStorage::kVisibility,
                                                          MatrixStorage::kCpca),
                                          testing::Values(LobeModel::kPhong, LobeModel::kGgx,
                                                          LobeModel::kTable)),
                         [](const auto& instance) {
                           return std::string(nameOf(std::get<0>(instance.param))) + "_" +
                                  nameOf(std::get<1>(instance.param));
                         });

// Through stored transferred radiance, and in one go through the tiles.
TEST(PackEvaluator, StoredRadianceGivesWhatShadeGives) {
  for (const MatrixStorage storage :
       {MatrixStorage::kMatrix, MatrixStorage::kVisibility, MatrixStorage::kCpca}) {
    formats::Pack pack = packOf(storage, LobeModel::kPhong);
    const GlossyEvaluator evaluator(pack.transfer);
    const std::vector<double> kernel = phongKernel(kRows, pack.transfer.material.exponent);
    std::vector<Float3> shaded(pack.mesh.vertexCount());
    evaluator.shade(
        someLight(0),
        lobeRows(pack, kernel, kEye, storage == MatrixStorage::kVisibility, evaluator.vertexOrder()), shaded);
    pack.transfer.vectors = {};
    const std::vector<Float3> found = evaluatePack(pack, someLight(0), {}, kEye);
    for (std::size_t v = 0; v < found.size(); ++v)
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(found[v][c], pack.transfer.material.specular_color[c] * shaded[v][c], 1e-5)
            << nameOf(storage);
  }
}

TEST(PackEvaluator, RefusesVectorsOfAnotherMesh) {
  formats::Pack pack = tests::wavyPack(kOrder, 10);
  pack.mesh.positions.pop_back();
  EXPECT_THROW(PackEvaluator evaluator(pack), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
