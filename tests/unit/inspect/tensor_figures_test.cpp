#include "tools/inspect/tensor_figures.h"

#include <cmath>

namespace bakelight::inspect {
namespace {

using formats::ElementType;
using formats::Tensor;
using ::testing::ElementsAre;

template <class T>
double firstOf(ElementType type, T value) {
  return elementOf(Tensor::from<T>(type, {1}, std::vector<T>{value}), 0);
}

TEST(TensorFigures, EveryElementTypeIsRead) {
  EXPECT_EQ(firstOf<float>(ElementType::kFloat32, -0.25f), -0.25);
  EXPECT_EQ(firstOf<double>(ElementType::kFloat64, 1e300), 1e300);
  EXPECT_EQ(firstOf<std::uint16_t>(ElementType::kFloat16, 0x3C00), 1.0);
  EXPECT_EQ(firstOf<std::uint16_t>(ElementType::kFloat16, 0xC100), -2.5);
  EXPECT_TRUE(std::isinf(firstOf<std::uint16_t>(ElementType::kFloat16, 0x7C00)));
  EXPECT_EQ(firstOf<std::uint8_t>(ElementType::kUint8, 200), 200);
  EXPECT_EQ(firstOf<std::uint16_t>(ElementType::kUint16, 60000), 60000);
  EXPECT_EQ(firstOf<std::uint32_t>(ElementType::kUint32, 4000000000U), 4e9);
  EXPECT_EQ(firstOf<std::int32_t>(ElementType::kInt32, -7), -7);
  EXPECT_EQ(firstOf<std::int64_t>(ElementType::kInt64, -(1LL << 40)), -std::ldexp(1, 40));
}

TEST(TensorFigures, MomentsByHand) {
  const Moments moments = measureTensor(
      Tensor::from<float>(ElementType::kFloat32, {2, 2}, std::vector<float>{1, -1, 3, std::nanf("")}));
  EXPECT_EQ(moments.minimum(), -1);
  EXPECT_EQ(moments.maximum(), 3);
  EXPECT_EQ(moments.mean(), 1);
  EXPECT_DOUBLE_EQ(moments.rootMeanSquare(), std::sqrt(11.0 / 3));
  EXPECT_EQ(moments.nanCount(), 1U);
}

TEST(TensorFigures, EnergyGoesToItsBandAndIsAveragedOverRows) {
  std::vector<float> vectors(2 * 9, 0.0f);
  vectors[0] = 2;       // row 0, l = 0
  vectors[3] = 1;       // row 0, l = 1, m = 1
  vectors[9 + 1] = 1;   // row 1, l = 1, m = −1
  vectors[9 + 4] = 3;   // row 1, l = 2, m = −2
  vectors[9 + 8] = -1;  // row 1, l = 2, m = 2
  EXPECT_THAT(bandEnergies(vectors, 3), ElementsAre(2, 1, 5));
}

TEST(TensorFigures, OnlySquaresHaveAnOrder) {
  EXPECT_EQ(orderOfColumns(1), 1);
  EXPECT_EQ(orderOfColumns(25), 5);
  EXPECT_EQ(orderOfColumns(100), 10);
  EXPECT_EQ(orderOfColumns(24), 0);
  EXPECT_EQ(orderOfColumns(0), 0);
  EXPECT_EQ(orderOfColumns(121), 0);
}

}  // namespace
}  // namespace bakelight::inspect
