#include "transport/evaluator.h"

#include <gtest/gtest.h>

namespace bakelight::transport {
namespace {

TEST(Evaluator, IsTheDotProductPerChannel) {
  const std::vector<float> vectors = {1, 2, 3, 4, 0.5f, 0, 0, -1};
  const std::vector<Float3> light = {{1, 0, 10}, {0, 1, 10}, {0, 0, 10}, {2, 0, 10}};
  const std::vector<Float3> radiance = evaluateDiffuse(vectors, 2, light);
  ASSERT_EQ(radiance.size(), 2u);
  EXPECT_EQ(radiance[0], (Float3{9, 2, 100}));
  EXPECT_EQ(radiance[1], (Float3{-1.5f, 0, -5}));
}

TEST(Evaluator, IgnoresFurtherBandsOfTheLight) {
  const std::vector<float> vectors = {2};
  EXPECT_EQ(evaluateDiffuse(vectors, 1, uniformLight(3, {1, 1, 1})),
            evaluateDiffuse(vectors, 1, uniformLight(1, {1, 1, 1})));
}

TEST(Evaluator, RefusesTablesThatDoNotFit) {
  const std::vector<float> vectors(5);
  EXPECT_THROW(evaluateDiffuse(vectors, 2, uniformLight(2, {1, 1, 1})), std::invalid_argument);
  EXPECT_THROW(evaluateDiffuse(std::vector<float>(9), 3, uniformLight(2, {1, 1, 1})), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
