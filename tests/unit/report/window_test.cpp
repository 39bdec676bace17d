// Windows that are chosen by what they save.
#include "tools/report/window.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/unit/report/made_report.h"
#include "tools/report/evaluation.h"
#include "transport/windowing.h"

namespace bakelight::report {
namespace {

using formats::Json;
using tests::madeGlossyPack, tests::MadeReport;

constexpr int kPixels = 40, kBands = 5;

Picture blackPicture() {
  return {formats::Image(kPixels, 1, {"R", "G", "B", "A"}), std::vector<std::uint8_t>(kPixels, 1)};
}

// Pixels that each band lights otherwise; the higher ones ring below zero.
std::vector<Picture> bands() {
  std::vector<Picture> pictures(kBands, blackPicture());
  for (int band = 0; band < kBands; ++band)
    for (int x = 0; x < kPixels; ++x)
      for (std::size_t c = 0; c < 3; ++c)
        pictures[static_cast<std::size_t>(band)].linear.texel(x, 0)[c] =
            static_cast<float>(0.4 * std::cos(band * (x + 0.3 * static_cast<double>(c)) * 0.37));
  return pictures;
}

WindowFit fitTo(double truth_lambda) {
  WindowFit fit;
  Reference truth{blackPicture(), {}};
  const std::vector<Picture> lit = bands();
  for (int band = 0; band < kBands; ++band)
    for (std::size_t i = 0; i < truth.picture.linear.values.size(); ++i)
      truth.picture.linear.values[i] += static_cast<float>(transport::bandFactor(band, truth_lambda)) *
                                        lit[static_cast<std::size_t>(band)].linear.values[i];
  fit.add(truth, lit, 0.8);
  return fit;
}

TEST(WindowFit, FindsTheWindowThatTheTruthHas) {
  for (const double lambda : {0.0, 1e-5 * 32, 1e-5 * 1024}) {
    const WindowChoice choice = fitTo(lambda).choose();
    EXPECT_NEAR(choice.lambda, lambda, 1e-9);
    EXPECT_LT(choice.error.displayed, 1e-5);
    EXPECT_LT(choice.error.radiance, 1e-5);
    EXPECT_EQ(choice.without.displayed > 0.02, lambda > 0);
  }
}

// Below zero all is black: a ring counts as it is seen.
TEST(WindowFit, NegativeRadianceIsShownAsBlack) {
  WindowFit fit;
  std::vector<Picture> lit(2, blackPicture());
  for (float& value : lit[0].linear.values) value = 0.1F;
  for (float& value : lit[1].linear.values) value = -5;
  Reference truth{blackPicture(), {}};
  for (float& value : truth.picture.linear.values) value = 0.1F;
  fit.add(truth, lit, 1);
  EXPECT_NEAR(fit.errorAt(0).displayed, 1, 1e-6);
  EXPECT_NEAR(fit.errorAt(0).radiance, 50, 1e-3);
}

// The sum of bands is the picture under the windowed light, and each light has its own window.
TEST(MeasuredWindows, AreThoseThatThePlayerWouldShow) {
  const formats::Pack truth = madeGlossyPack(8);
  MadeReport made(truth);
  made.addVariant("order=4", Json::object(), madeGlossyPack(4));
  for (Json& view : made.json["views"]) view["windowing"] = "measured";
  const auto evaluated = [&] {
    const Plan plan = made.plan();
    const Sources sources = made.sources();
    return Evaluator(plan, sources).evaluate(1, [] {}).variants.front();
  };
  const VariantFigures measured = evaluated();
  ASSERT_EQ(measured.windows.size(), 2u);
  for (std::size_t view = 0; view < 2; ++view) {
    const WindowChoice& choice = measured.windows[view].choice;
    EXPECT_EQ(measured.windows[view].light, made.json["views"][view]["light"].get<std::string>());
    EXPECT_LE(choice.error.displayed, choice.without.displayed);
    made.json["views"][view]["windowing"] = choice.lambda;
  }
  EXPECT_GT(measured.windows[0].choice.lambda, 0) << "a sun";
  EXPECT_LT(measured.windows[0].choice.error.displayed, measured.windows[0].choice.without.displayed);
  const VariantFigures fixed = evaluated();
  EXPECT_TRUE(fixed.windows.empty());
  for (std::size_t view = 0; view < 2; ++view) {
    EXPECT_NEAR(fixed.view_errors[view].rel_rmse, measured.view_errors[view].rel_rmse, 1e-5);
    EXPECT_NEAR(fixed.view_errors[view].rel_rmse, measured.windows[view].choice.error.radiance, 1e-5);
  }
}

}  // namespace
}  // namespace bakelight::report
