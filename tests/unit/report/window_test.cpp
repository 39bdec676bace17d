// Windows that are chosen by what they save.
#include "tools/report/window.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/unit/neighborhood/made_neighborhood.h"
#include "tests/unit/report/made_report.h"
#include "tools/report/evaluation.h"
#include "transport/frame.h"
#include "transport/neighborhood_shading.h"
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

formats::Pack onGround(formats::Pack pack) {
  pack.neighborhood = formats::PackPart(
      tests::groundOf(pack.mesh, tests::unshadowedLight(pack.mesh, pack.sh().order, {0.5F, 0.5F, 0.5F})));
  return pack;
}

// A ground is seen where the object is not, as it is lit; what the reference does not show of it does not count.
TEST(MeasuredWindows, GroundIsPartOfThePicture) {
  const formats::Pack pack = onGround(madeGlossyPack(4));
  MadeReport made(madeGlossyPack(8));
  made.addVariant("ground", Json::object(), pack);
  made.addVariant("none", Json::object(), madeGlossyPack(4));
  for (Json& view : made.json["views"]) view["windowing"] = "measured";
  const Plan plan = made.plan();
  const Sources sources = made.sources();
  const Evaluation evaluation = Evaluator(plan, sources).evaluate(1, [] {});
  for (std::size_t view = 0; view < 2; ++view) {
    EXPECT_EQ(evaluation.variants[0].windows[view].choice.error.displayed,
              evaluation.variants[1].windows[view].choice.error.displayed);
    EXPECT_EQ(evaluation.variants[0].view_errors[view].coverage_error,
              evaluation.variants[1].view_errors[view].coverage_error);
    EXPECT_EQ(evaluation.variants[0].view_errors[view].flip, evaluation.variants[1].view_errors[view].flip);
  }

  const PlanView& view = plan.views[0];
  const transport::OrbitCamera camera =
      transport::frameCamera(view.frame, transport::boundingSphere(pack.mesh));
  Renderer renderer(plan, {camera, camera}, sources);
  Renderer::Conditions conditions;
  Picture picture =
      renderer
          .picturesOf(pack,
                      [&](std::size_t of, const Renderer::Conditions& its, transport::PackShading& shading) {
                        if (of == 0) conditions = its;
                        its.light(shading);
                      })
          .front();
  const Picture object = picture;
  Picture reference = picture;
  renderer.addGround(pack, 0, conditions, reference, picture);
  EXPECT_EQ(picture.linear.values, object.linear.values) << "the reference shows the object alone";
  reference.covered.assign(reference.covered.size(), 1);
  renderer.addGround(pack, 0, conditions, reference, picture);
  transport::GroundShading ground(*pack.neighborhood->as<formats::Neighborhood>());
  ground.setLight(transport::ShRotation(4, transport::worldFromLight(view.frame)).apply(conditions.distant),
                  {});
  std::size_t ground_pixels = 0;
  for (std::size_t pixel = 0; pixel < picture.covered.size(); ++pixel) {
    const float* now = &picture.linear.values[4 * pixel];
    const float* before = &object.linear.values[4 * pixel];
    if (before[3] > 0 || picture.covered[pixel] == 0) {
      EXPECT_TRUE(std::equal(now, now + 4, before)) << pixel;
      continue;
    }
    ++ground_pixels;
    const auto x = static_cast<double>(pixel % static_cast<std::size_t>(view.frame.width_px)),
               y = static_cast<double>(pixel / static_cast<std::size_t>(view.frame.width_px));
    const formats::Float4 right = ground.seen(
        camera.eye(), camera.directionThrough(x + 0.5, y + 0.5, view.frame.width_px, view.frame.height_px),
        {0.5F, 0.5F, 0.5F});
    for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(now[c], right[c], 1e-5);
  }
  EXPECT_GT(ground_pixels, 300u);
}

}  // namespace
}  // namespace bakelight::report
