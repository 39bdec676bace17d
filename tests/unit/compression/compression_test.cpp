#include "compression/compressed_transfer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <random>

#include "compression/clustered_rows.h"
#include "compression/errors.h"
#include "compression/haar_rows.h"
#include "compression/harmonics.h"
#include "compression/wavelets_4d.h"
#include "formats/symbol_code.h"
#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::compression {
namespace {

using formats::PixelCodes;
using formats::PixelRows;
using transport::Vec3;

// What vertices along an arc of a cylinder see of the sky, whose frames turn slowly; a wall hides a part.
PixelRows arc(int vertices, int cube_side, int local_side, double wall = 0.3) {
  PixelRows rows;
  rows.cube_side = cube_side, rows.local_side = local_side, rows.subsamples = 2;
  for (int v = 0; v < vertices; ++v) {
    const double angle = 0.02 * v;
    const Vec3 normal(std::sin(angle), std::cos(angle), 0), tangent(std::cos(angle), -std::sin(angle), 0),
        bitangent = normal.cross(tangent);
    std::vector<std::vector<std::pair<std::uint16_t, std::uint8_t>>> cells(
        static_cast<std::size_t>(local_side) * local_side);
    for (int k = 0; k < 6 * cube_side * cube_side; ++k) {
      const int x = k % cube_side, y = k / cube_side % cube_side;
      std::uint8_t code = 0;
      for (int s = 0; s < 4; ++s) {
        const Vec3 d =
            transport::directionOfCubeFace(k / cube_side / cube_side, (x + (s % 2 + 0.5) / 2) / cube_side,
                                           (y + (s / 2 + 0.5) / 2) / cube_side);
        if (d.dot(normal) > 0 && d.z() > wall - 1 + 0.01 * v) ++code;
      }
      const Vec3 d = transport::directionOfCubeFace(k / cube_side / cube_side, (x + 0.5) / cube_side,
                                                    (y + 0.5) / cube_side);
      if (code == 0) continue;
      const auto at = transport::squareFromHemisphere(Vec3(d.dot(tangent), d.dot(bitangent), d.dot(normal)));
      const int column = std::min(local_side - 1, static_cast<int>(at.a * local_side)),
                row = std::min(local_side - 1, static_cast<int>(at.b * local_side));
      cells[static_cast<std::size_t>(row) * local_side + column].emplace_back(static_cast<std::uint16_t>(k),
                                                                              code);
    }
    for (const auto& cell : cells) {
      for (const auto& [k, code] : cell) rows.columns.push_back(k), rows.codes.push_back(code);
      rows.row_offsets.push_back(rows.columns.size());
    }
  }
  return rows;
}

std::vector<Radiance4> someLight(const PixelCodes& codes) {
  std::vector<Radiance4> light(codes.columnCount());
  for (std::size_t k = 0; k < light.size(); ++k)
    light[k] = Radiance4(1, 0.7F, 0.4F, 0) * (1 + 0.01F * static_cast<float>(k * 7919 % 1000));
  return light;
}

std::vector<Radiance4> exact(const PixelCodes& codes, std::span<const Radiance4> light) {
  std::vector<Radiance4> values(codes.rowCount());
  transport::multiply(codes, light, values);
  return values;
}

std::vector<std::uint32_t> inOrder(std::size_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  return order;
}

TEST(SymbolCode, GivesSymbolsBack) {
  std::vector<std::uint32_t> symbols;
  for (std::uint32_t i = 0; i < 5000; ++i) symbols.push_back(i % 7 == 0 ? i % 400 : i % 3);
  const auto bytes = formats::encodeSymbols(symbols);
  EXPECT_EQ(formats::decodeSymbols(bytes), symbols);
  EXPECT_LT(bytes.size(), symbols.size());
  EXPECT_TRUE(formats::decodeSymbols(formats::encodeSymbols({})).empty());
  for (const std::int32_t value : {0, -1, 1, -2, 70000, -70000})
    EXPECT_EQ(formats::valueOf(formats::symbolOf(value)), value);
  EXPECT_EQ(formats::symbolOf(-1), 1U);
  EXPECT_THROW(formats::encodeSymbols(std::vector<std::uint32_t>{1U << 31}), std::invalid_argument);
}

TEST(Haar, IsOrthonormalAndItsOwnInverse) {
  for (const int side : {1, 2, 8}) {
    const std::size_t texels = 6 * static_cast<std::size_t>(side) * side;
    std::vector<Radiance4> a(texels), b(texels);
    for (std::size_t k = 0; k < texels; ++k) {
      a[k] = Radiance4::Constant(static_cast<float>(k * 37 % 11));
      b[k] = Radiance4::Constant(static_cast<float>(k * 53 % 7) - 2);
    }
    const auto dot = [&](const auto& x, const auto& y) {
      double sum = 0;
      for (std::size_t k = 0; k < texels; ++k) sum += double{x[k](0)} * y[k](0);
      return sum;
    };
    std::vector<Radiance4> fa = a, fb = b;
    forwardHaar(side, fa), forwardHaar(side, fb);
    EXPECT_NEAR(dot(fa, fb), dot(a, b), 1e-3 * std::abs(dot(a, a)));
    EXPECT_NEAR(dot(fa, fa), dot(a, a), 1e-5 * dot(a, a));
    inverseHaar(side, fa);
    for (std::size_t k = 0; k < texels; ++k) EXPECT_NEAR(fa[k](0), a[k](0), 1e-4F);
  }
  EXPECT_FALSE(hasHaar(12));
  std::vector<Radiance4> twelve(6 * 144);
  EXPECT_THROW(forwardHaar(12, twelve), std::invalid_argument);
}

TEST(Haar, OfConstantLightIsOneCoefficientAFace) {
  constexpr int kSide = 16;
  std::vector<Radiance4> light(6 * kSide * kSide, Radiance4::Constant(3));
  forwardHaar(kSide, light);
  for (std::size_t k = 0; k < light.size(); ++k)
    EXPECT_FLOAT_EQ(light[k](0), k % (kSide * kSide) == 0 ? 3.0F * kSide : 0.0F) << k;
}

// A texel is in one support of each of three wavelets a level, and in the mean's: amplitudes 2^−level.
TEST(Haar, OfOneTexelHasThreeCoefficientsALevel) {
  PixelRows rows;
  rows.cube_side = 8, rows.local_side = 1, rows.subsamples = 2;
  rows.columns = {static_cast<std::uint16_t>(2 * 64 + 5 * 8 + 3)};
  rows.codes = {2};
  rows.row_offsets = {0, 1};
  const WaveletRows haar = haarRows(rows.view());
  ASSERT_EQ(haar.indices.size(), 3 * 3 + 1U);
  std::vector<Radiance4> dense(6 * 64, Radiance4::Zero());
  dense[rows.columns[0]] = Radiance4::Constant(0.5F);
  forwardHaar(8, dense);
  for (std::size_t i = 0; i < haar.indices.size(); ++i) EXPECT_EQ(haar.values[i], dense[haar.indices[i]](0));
  std::vector<float> magnitudes;
  for (const float value : haar.values) magnitudes.push_back(std::abs(value));
  std::sort(magnitudes.begin(), magnitudes.end());
  EXPECT_EQ(magnitudes.front(), 0.5F / 8);
  EXPECT_EQ(magnitudes[4], 0.5F / 4);
  EXPECT_EQ(magnitudes.back(), 0.5F / 2);
}

TEST(Haar, AreasAreThoseOfSupports) {
  constexpr int kSide = 8;
  const std::vector<float> areas = haarAreas(kSide);
  ASSERT_EQ(areas.size(), 6U * kSide * kSide);
  const double face = 4 * std::numbers::pi / 6;
  EXPECT_NEAR(areas[0], face, 1e-5);  // the mean
  EXPECT_NEAR(areas[1], face, 1e-5);  // the coarsest detail across
  EXPECT_NEAR(areas[kSide * kSide + 2], face / 4, 1e-5) << "of a quarter of a face, by symmetry";
  const double pair =
      transport::cubeTexelSolidAngle(2, 4, kSide) + transport::cubeTexelSolidAngle(3, 4, kSide) +
      transport::cubeTexelSolidAngle(2, 5, kSide) + transport::cubeTexelSolidAngle(3, 5, kSide);
  EXPECT_NEAR(areas[2 * kSide + 1 + kSide / 2], pair, 1e-6);
}

// With all that there is to keep, each method is the matrix.
TEST(Rivals, ReproduceTheMatrixWithAllCoefficients) {
  const PixelRows rows = arc(40, 8, 4);
  const PixelCodes codes = rows.view();
  const std::vector<Radiance4> light = someLight(codes), truth = exact(codes, light);
  const WaveletRows haar = haarRows(codes);
  constexpr std::uint64_t kPlenty = 1 << 24;
  EXPECT_EQ(relativeRms(plainRows(codes).incident(light), truth), 0);
  // Quantised to 6 bits of the largest coefficient.
  EXPECT_LT(relativeRms(haarWithin(kPlenty, haar, Selection::kAreaWeighted).incident(light), truth), 0.04);
  EXPECT_LT(relativeRms(haarWithin(kPlenty, haar, Selection::kMagnitude).incident(light), truth), 0.04);
  EXPECT_LT(relativeRms(wavelets4dWithin(kPlenty, haar, 4, inOrder(40)).incident(light), truth), 0.05);
  const RowClusters all = clusterRows(codes, {.clusters = 8, .components = 80});
  EXPECT_LT(relativeRms(clusteredWithin(kPlenty, all).incident(light), truth), 0.01);
}

// Vertices in another order are the same matrix.
TEST(Rivals, FourDimensionalWaveletsPutRowsBack) {
  const PixelRows rows = arc(70, 8, 4);  // a whole block and a part
  const PixelCodes codes = rows.view();
  const std::vector<Radiance4> light = someLight(codes), truth = exact(codes, light);
  std::vector<std::uint32_t> order = inOrder(70);
  std::reverse(order.begin(), order.end());
  std::swap(order[3], order[60]);
  EXPECT_LT(relativeRms(wavelets4dWithin(1 << 24, haarRows(codes), 4, order).incident(light), truth), 0.05);
  order.pop_back();
  EXPECT_THROW(wavelets4dWithin(1 << 24, haarRows(codes), 4, order), std::invalid_argument);
}

// One cluster of rank 1: rows that are multiples of one another.
TEST(Rivals, ClustersFindRowsOfOneComponent) {
  PixelRows rows;
  rows.cube_side = 4, rows.local_side = 1, rows.subsamples = 4;
  for (int row = 0; row < 40; ++row) {
    for (int k = 0; k < 20; ++k) {
      rows.columns.push_back(static_cast<std::uint16_t>(4 * k + row % 2));
      rows.codes.push_back(static_cast<std::uint8_t>(1 + row % 10));
    }
    rows.row_offsets.push_back(rows.columns.size());
  }
  rows.row_offsets.push_back(rows.columns.size());  // and one without anything
  const PixelCodes codes = rows.view();
  const RowClusters clusters = clusterRows(codes, {.clusters = 2, .components = 1});
  ASSERT_EQ(clusters.bases.size(), 2U);
  EXPECT_NE(clusters.clusters[0], clusters.clusters[1]);
  EXPECT_EQ(clusters.clusters[0], clusters.clusters[2]);
  EXPECT_EQ(clusters.clusters[40], RowClusters::kNone);
  const std::vector<Radiance4> light = someLight(codes), truth = exact(codes, light);
  EXPECT_LT(relativeRms(clusteredWithin(1 << 20, clusters).incident(light), truth), 1e-3);
}

// Light of few bands over open ground comes back, and the coefficients of each vertex are those of its own frame.
TEST(Rivals, HarmonicsKeepLightOfFewBands) {
  const PixelRows rows = arc(3, 32, 8, -2);
  const PixelCodes codes = rows.view();
  std::vector<Radiance4> light(codes.columnCount());
  for (std::size_t k = 0; k < light.size(); ++k) {
    const int texel = static_cast<int>(k);
    const Vec3 d =
        transport::directionOfCubeFace(texel / 1024, (texel % 32 + 0.5) / 32, (texel / 32 % 32 + 0.5) / 32);
    const auto sr = static_cast<float>(transport::cubeTexelSolidAngle(texel % 32, texel / 32 % 32, 32));
    light[k] = Radiance4::Constant(sr * static_cast<float>(1 + 0.5 * d.x() + 0.3 * d.y()));
  }
  const std::vector<Radiance4> truth = exact(codes, light),
                               values = harmonicsWithin(1 << 20, codes, 5).incident(light);
  double sum = 0, sum_of_truth = 0;
  for (std::size_t row = 0; row < 64; ++row) sum += values[row](0), sum_of_truth += truth[row](0);
  EXPECT_NEAR(sum, sum_of_truth, 0.05 * sum_of_truth);
  EXPECT_LT(relativeRms(values, truth), 0.35) << "the horizon, in five bands";
}

struct Method {
  const char* name;
  std::function<CompressedTransfer(std::uint64_t, const PixelCodes&)> make;
};
void PrintTo(const Method& method, std::ostream* out) {
  *out << method.name;
}
constexpr int kLocal = 8;
const Method kMethods[] = {
    {"Haar",
     [](std::uint64_t budget, const PixelCodes& codes) {
       return haarWithin(budget, haarRows(codes), Selection::kAreaWeighted);
     }},
    {"Wavelets4d",
     [](std::uint64_t budget, const PixelCodes& codes) {
       return wavelets4dWithin(budget, haarRows(codes), kLocal,
                               inOrder(codes.rowCount() / (kLocal * kLocal)));
     }},
    {"Clusters",
     [](std::uint64_t budget, const PixelCodes& codes) {
       return clusteredWithin(budget, clusterRows(codes, {.clusters = 6, .components = 4}));
     }},
    {"Harmonics",
     [](std::uint64_t budget, const PixelCodes& codes) { return harmonicsWithin(budget, codes, 5); }},
};

class Rival : public testing::TestWithParam<Method> {};

TEST_P(Rival, UsesItsBudgetAndErrsLessWithMore) {
  const PixelRows rows = arc(160, 16, kLocal);
  const PixelCodes codes = rows.view();
  const std::vector<Radiance4> light = someLight(codes), truth = exact(codes, light);
  double before = std::numeric_limits<double>::infinity();
  for (const std::uint64_t budget : {20000U, 40000U}) {
    const CompressedTransfer transfer = GetParam().make(budget, codes);
    EXPECT_LE(transfer.bytes, budget) << transfer.parameters;
    EXPECT_GE(transfer.bytes, 0.98 * static_cast<double>(budget)) << transfer.parameters;
    EXPECT_GT(transfer.operations, 0U);
    const double error = relativeRms(transfer.incident(light), truth);
    EXPECT_LT(error, before * 1.02) << transfer.parameters;
    EXPECT_LT(error, 0.9) << transfer.parameters;
    before = error;
  }
  EXPECT_THROW(GetParam().make(3, codes), std::invalid_argument);
}

TEST_P(Rival, IsTheSameOnOneThread) {
  const PixelRows rows = arc(100, 16, kLocal);
  const PixelCodes codes = rows.view();
  const std::vector<Radiance4> light = someLight(codes);
  const CompressedTransfer many = GetParam().make(20000, codes);
  const std::vector<Radiance4> values = many.incident(light);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const CompressedTransfer alone = GetParam().make(20000, codes);
  EXPECT_EQ(alone.bytes, many.bytes);
  EXPECT_EQ(alone.incident(light), values);
}

INSTANTIATE_TEST_SUITE_P(Methods, Rival, testing::ValuesIn(kMethods),
                         [](const auto& method) { return std::string(method.param.name); });

TEST(SolveForBytes, ComesWithinTwoPercentOrSaysWhyNot) {
  int calls = 0;
  const auto bytes = [&](double x) {
    ++calls;
    return static_cast<std::uint64_t>(1e8 * std::exp(-12 * x));
  };
  for (const std::uint64_t budget : {1000U, 100000U, 50000000U}) {
    const Solved solved = solveForBytes(bytes, budget);
    EXPECT_LE(solved.bytes, budget);
    EXPECT_GE(solved.bytes, 0.98 * static_cast<double>(budget));
    EXPECT_EQ(solved.bytes, bytes(solved.at));
  }
  EXPECT_LT(calls, 36);
  EXPECT_THROW(solveForBytes(bytes, 100), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::compression
