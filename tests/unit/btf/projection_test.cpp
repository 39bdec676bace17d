#include "tools/btf/projection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/unit/btf/btf_maker.h"
#include "tools/btf/crop.h"
#include "tools/btf/scattered_directions.h"
#include "transport/directions.h"
#include "transport/gauss_legendre.h"
#include "transport/hemisphere_grid.h"
#include "transport/sh.h"

namespace bakelight::btf {
namespace {

using formats::BtfDirection;
using formats::MadeBtf;

constexpr double kPi = std::numbers::pi;
constexpr double kLambert[] = {0.886227, 1.023327, 0.495416, 0, -0.110778};

using Reflectance = std::function<double(const Vec3& light, const Vec3& view)>;

// Grey, times a factor a texel; with the cosine of light.
MadeBtf measured(std::vector<BtfDirection> directions, const Reflectance& reflectance, int width = 2,
                 int height = 1) {
  MadeBtf made;
  made.views = directions, made.lights = std::move(directions);
  made.width = width, made.height = height;
  made.value = [reflectance](const BtfDirection& view, const BtfDirection& light, int texel) {
    const double value =
        reflectance(vectorOf(light), vectorOf(view)) * std::cos(light.polar_rad) * (1 + 0.5 * texel);
    return std::array<double, 3>{value, 0.5 * value, 0.25 * value};
  };
  return made;
}

std::unique_ptr<formats::Btf> btfOf(const MadeBtf& made) {
  return formats::btfOf(made.info(), made.values());
}

// Of texel 0's red: ∫ y_i f cos θ.
std::vector<double> integrated(const Reflectance& reflectance, const Vec3& view, int order) {
  std::vector<double> sums(static_cast<std::size_t>(order * order));
  constexpr int kRings = 60, kAround = 120;
  for (const auto& [x, weight] : transport::gaussLegendreRule(kRings))
    for (int a = 0; a < kAround; ++a) {
      const double z = (x + 1) / 2, azimuth = 2 * kPi * a / kAround, flat = std::sqrt(1 - z * z);
      const Vec3 light(flat * std::cos(azimuth), flat * std::sin(azimuth), z);
      const std::vector<double> y = transport::evaluateSh(order, light);
      for (std::size_t i = 0; i < sums.size(); ++i)
        sums[i] += weight / 2 * 2 * kPi / kAround * z * reflectance(light, view) * y[i];
    }
  return sums;
}

// Of light from cells: a Lambertian has albedo ÷ π × the cell's mean cosine; a lobe the mean over the cell.
TEST(Resampling, GivesTheMeanOverCellsOfLight) {
  const auto directions = [] {
    std::vector<BtfDirection> all = {{0, 0}};
    for (int ring = 1; ring <= 5; ++ring)
      for (int a = 0; a < 6 * ring; ++a)
        all.push_back({ring * 15 * formats::kDegree, a * 60.0 / ring * formats::kDegree});
    return all;
  }();
  const ProjectionOptions options{.views = 3};
  const GridLights grid{4, 2};
  const auto at = [](int view, int texel, int color, int cell) {
    return static_cast<std::size_t>(((view * 2 + texel) * 3 + color) * 16 + cell);
  };
  const std::vector<float> flat = resample(
      *btfOf(measured(directions, [](const Vec3&, const Vec3&) { return 0.6 / kPi; })), options, grid);
  ASSERT_EQ(flat.size(), std::size_t{9} * 2 * 3 * 16);
  for (int view = 0; view < 9; ++view)
    for (int cell = 0; cell < 16; ++cell)
      for (int color = 0; color < 3; ++color)
        ASSERT_NEAR(
            flat[at(view, 1, color, cell)],
            0.6 / kPi * 1.5 * std::pow(0.5, color) * transport::hemisphereCellCosine(4, cell % 4, cell / 4),
            1e-5)
            << view << ' ' << cell;

  const Reflectance lobe = [](const Vec3& light, const Vec3& view) {
    const Vec3 mirrored(-view.x(), -view.y(), view.z());
    return 0.1 + std::pow(std::max(0.0, mirrored.dot(light)), 4);
  };
  const std::vector<float> shiny = resample(*btfOf(measured(directions, lobe)), options, grid);
  const Vec3 towards = transport::hemisphereCell(3, 2, 1);
  double largest = 0;
  for (const float value : shiny) largest = std::max(largest, double{value});
  for (int cell = 0; cell < 16; ++cell) {
    double mean = 0;
    constexpr int kFine = 12;
    for (int i = 0; i < kFine * kFine; ++i) {
      const Vec3 light = transport::hemisphereFromSquare((cell % 4 + (i % kFine + 0.5) / kFine) / 4,
                                                         (cell / 4 + (i / kFine + 0.5) / kFine) / 4);
      mean += lobe(light, towards) * light.z() / (kFine * kFine);
    }
    EXPECT_NEAR(shiny[at(5, 0, 0, cell)], mean, 0.06 * largest / 1.5) << cell;
  }
}

void expectLambert(const formats::RadianceTransferTexture& texture, double albedo, double tolerance,
                   const std::string& what) {
  for (int row = 0; row < texture.views; ++row)
    for (int column = 0; column < texture.views; ++column)
      for (int x = 0; x < texture.width; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          for (int l = 0; l < texture.order; ++l)
            for (int m = -l; m <= l; ++m) {
              const double own = albedo / kPi * (1 + 0.5 * x) * std::pow(0.5, static_cast<double>(c));
              ASSERT_NEAR(
                  texture.response(column, row, x, 0)[c * 25 + static_cast<std::size_t>(l * (l + 1) + m)],
                  m == 0 ? own * kLambert[l] : 0, tolerance)
                  << what << ": view " << column << ", " << row << ", channel " << c << ", l " << l << ", m "
                  << m;
            }
}

const Reflectance kHalfLambert = [](const Vec3&, const Vec3&) { return 0.5 / kPi; };
// A broad lobe around the mirror direction on a diffuse base: smooth, but it has all bands.
const Reflectance kLobe = [](const Vec3& light, const Vec3& view) {
  const double cosine = std::max(view.dot(Vec3(-light.x(), -light.y(), light.z())), 0.0);
  return 0.2 / kPi + 0.4 / kPi * std::pow(cosine, 4);
};

TEST(BtfProjection, OfAFlatLambertianIsTheClampedCosine) {
  for (const auto& directions : {formats::directions81(), formats::directions151()}) {
    ASSERT_TRUE(directions.size() == 81 || directions.size() == 151);
    expectLambert(project(*btfOf(measured(directions, kHalfLambert)), {}).texture, 0.5, 2e-6, "in memory");
  }
}

TEST(BtfProjection, OfAFileOfEveryLayoutIsThatOfItsValues) {
  const std::filesystem::path folder = testing::TempDir() + "btf_projection_test";
  std::map<std::string, formats::BtfVariant> variants = {
      {"dfmf", {}},
      {"dfmf_log_half", {.scalar = 2, .color_model = 11}},
      {"dfmf_transposed", {.transposed = true, .color_model = 4}},
      {"fmf", {.signature = "!FMF06FC"}},
      {"fmf_log", {.signature = "!FMF12FCER", .is_logarithmic = true}},
      {"pvf", {.signature = "!PVF06FCR", .transposed = true}},
      {"bdi", {.signature = "!BDIF06R2!"}}};
  for (const auto& [name, variant] : variants) {
    const std::filesystem::path path = folder / (name + ".btf");
    formats::writeFileAtomically(
        path, formats::BtfMaker(measured(formats::directions81(), kHalfLambert), variant).bytes());
    const bool is_half = variant.scalar == 2 || name == "bdi";
    expectLambert(project(*formats::openBtf(path), {}).texture, 0.5, is_half ? 4e-4 : 2e-6, name);
  }
}

// 151 directions, 15° apart: within 2% of the largest coefficient of texel 0.
TEST(BtfProjection, OfASmoothLobeIsItsIntegral) {
  const Projected projected = project(*btfOf(measured(formats::directions151(), kLobe)), {});
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) {
      const Vec3 view = transport::hemisphereCell(8, column, row);
      if (view.z() < std::cos(75 * kPi / 180))
        continue;  // beyond the outermost views there are none to go by
      const std::vector<double> expected = integrated(kLobe, view, 5);
      for (std::size_t i = 0; i < 25; ++i)
        EXPECT_NEAR(projected.texture.response(column, row, 0, 0)[i], expected[i], 0.02 * expected[2])
            << "view " << column << ", " << row << ", coefficient " << i;
    }
  EXPECT_FALSE(projected.figures.is_joint);
  EXPECT_GT(projected.figures.view_dependence, 0.05);
  EXPECT_NEAR(projected.figures.largest_view_radiance, projected.figures.mean_radiance[0], 0.4);
}

// 1 + a·x of light, b·y of view: which way the axes run, of lights and of the grid of views.
TEST(BtfProjection, TurnsAzimuthsFromRightToTop) {
  const Reflectance tilted = [](const Vec3& light, const Vec3& view) {
    return (1 + 0.5 * light.y()) * (1 + 0.5 * view.x()) / kPi;
  };
  const auto btf = btfOf(measured(formats::directions151(), tilted));
  const auto texture = project(*btf, {}).texture;
  EXPECT_GT(texture.response(4, 4, 0, 0)[1], 0.05) << "l = 1, m = -1 is y";
  EXPECT_NEAR(texture.response(4, 4, 0, 0)[3], 0, 1e-3);
  EXPECT_GT(texture.response(7, 4, 0, 0)[0], 1.5 * texture.response(0, 4, 0, 0)[0]);
  EXPECT_NEAR(texture.response(3, 7, 0, 0)[0], texture.response(3, 0, 0, 0)[0], 1e-2);
  const auto mirrored = project(*btf, {.clockwise = true}).texture;
  EXPECT_NEAR(mirrored.response(4, 4, 0, 0)[1], -texture.response(4, 3, 0, 0)[1], 1e-3);
  EXPECT_GT(mirrored.response(7, 4, 0, 0)[0], 1.5 * mirrored.response(0, 4, 0, 0)[0]);
}

TEST(BtfProjection, TakesTheCosineAsItIsTold) {
  MadeBtf made = measured(formats::directions81(), kHalfLambert);
  const auto with = btfOf(made);
  formats::BtfInfo info = made.info();
  info.cosine_inside = false;
  made.value = [](const auto&, const auto&, int texel) {
    const double value = 0.5 / kPi * (1 + 0.5 * texel);
    return std::array<double, 3>{value, 0.5 * value, 0.25 * value};
  };
  const auto without = formats::btfOf(info, made.values());
  expectLambert(project(*without, {}).texture, 0.5, 2e-6, "the file says outside");
  expectLambert(project(*with, {.scale = 2}).texture, 1, 4e-6, "scaled");
  const auto wrong = project(*without, {.cosine = Cosine::kInside}).texture;
  EXPECT_GT(wrong.response(4, 4, 0, 0)[0], 1.3 * 0.5 / kPi * kLambert[0]);
}

TEST(BtfProjection, OfOneViewIsTheMeanOverViews) {
  const auto btf = btfOf(measured(formats::directions151(), kLobe));
  const auto one = project(*btf, {.views = 1}).texture, all = project(*btf, {}).texture;
  for (std::size_t i = 0; i < 75; ++i) {
    double mean = 0;
    for (std::size_t v = 0; v < 64; ++v) mean += all.values[v * 150 + i] / 64.0;
    EXPECT_NEAR(one.values[i], mean, 1e-6);
  }
}

// Pictures of some pairs only, as of CUReT: 205 of 205 × 205.
class Scattered : public formats::Btf {
 public:
  Scattered(formats::BtfInfo info, Reflectance reflectance)
      : Btf(std::move(info)), reflectance_(std::move(reflectance)) {}
  std::vector<int> lightsOf(int view) const override { return {view}; }
  std::shared_ptr<const formats::BtfView> view(int view) const override {
    struct View : formats::BtfView {
      View(std::shared_ptr<const formats::BtfInfo> info, int view, Reflectance r)
          : BtfView(std::move(info), view), reflectance(std::move(r)) {}
      void decodeValues(std::span<const int> lights, formats::BtfTexels texels,
                        std::span<float> rgb) const override {
        for (std::size_t i = 0; i < rgb.size(); ++i) {
          const Vec3 light =
              vectorOf(info().lights[static_cast<std::size_t>(lights[i / texels.count % lights.size()])]);
          const Vec3 towards = vectorOf(info().views[static_cast<std::size_t>(index())]);
          rgb[i] = static_cast<float>(light.z() * reflectance(light, towards));
        }
      }
      Reflectance reflectance;
    };
    return std::make_shared<View>(sharedInfo(), view, reflectance_);
  }

 private:
  Reflectance reflectance_;
};

Scattered scattered(const Reflectance& reflectance, int count) {
  formats::BtfInfo info;
  info.width = 1, info.height = 1;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit;
  for (int i = 0; i < count; ++i)
    for (auto* list : {&info.views, &info.lights})
      list->push_back({std::acos(0.15 + 0.85 * unit(random)), 2 * kPi * unit(random)});
  return {std::move(info), reflectance};
}

TEST(BtfProjection, OfPairsThatLieAnyhowReturnsConstantsAndSmoothFunctions) {
  const Projected flat = project(scattered(kHalfLambert, 205), {});
  EXPECT_TRUE(flat.figures.is_joint);
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column)
      for (int l = 0; l < 5; ++l)
        EXPECT_NEAR(flat.texture.response(column, row, 0, 0)[static_cast<std::size_t>(l * (l + 1))],
                    0.5 / kPi * kLambert[l], 1e-5);
  const Reflectance smooth = [](const Vec3& light, const Vec3& view) {
    return (1 + 0.3 * light.x() + 0.3 * view.y()) / kPi;
  };
  const Projected projected = project(scattered(smooth, 205), {.order = 2});
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) {
      const std::vector<double> expected = integrated(smooth, transport::hemisphereCell(8, column, row), 2);
      for (std::size_t i = 0; i < 4; ++i)
        EXPECT_NEAR(projected.texture.response(column, row, 0, 0)[i], expected[i], 0.05);
    }
}

TEST(BtfProjection, GivesTheSameBytesWithAnyNumberOfThreads) {
  const auto btf = btfOf(measured(formats::directions81(), kLobe, 20, 14));
  std::vector<float> one;
  {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    one = project(*btf, {}).texture.values;
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
  EXPECT_EQ(project(*btf, {}).texture.values, one);
}

double interpolated(const ScatteredDirections& between, const Vec3& at, const std::vector<Vec3>& directions,
                    const std::function<double(const Vec3&)>& function) {
  double sum = 0;
  for (const auto& [index, weight] : between.shares(at))
    sum += weight * function(directions[static_cast<std::size_t>(index)]);
  return sum;
}

TEST(ScatteredDirections, ReturnsConstantsEverywhereAndSmoothFunctionsWithin) {
  const auto smooth = [](const Vec3& v) { return 0.5 + v.x() * v.z() + 0.5 * v.y(); };
  for (const auto& [angles, bound] :
       {std::pair(formats::directions81(), 0.05), std::pair(formats::directions151(), 0.04)}) {
    std::vector<Vec3> directions;
    for (const BtfDirection& angle : angles) directions.push_back(vectorOf(angle));
    const ScatteredDirections between(directions);
    double largest = 0;
    for (const Vec3& at : transport::sphereDirections(3000)) {
      if (at.z() < 0) continue;
      double sum = 0;
      for (const auto& [index, weight] : between.shares(at)) {
        EXPECT_GT(weight, 0);
        sum += weight;
      }
      ASSERT_NEAR(sum, 1, 1e-12);
      if (at.z() > std::cos(72 * kPi / 180))
        largest = std::max(largest, std::abs(interpolated(between, at, directions, smooth) - smooth(at)));
    }
    EXPECT_LT(largest, bound);
    for (std::size_t i = 0; i < directions.size(); ++i)
      EXPECT_NEAR(interpolated(between, directions[i], directions, smooth), smooth(directions[i]), 1e-9) << i;
  }
}

TEST(ScatteredDirections, TakesFewOnALineOrTheSameTwice) {
  const Vec3 zenith(0, 0, 1), right = Vec3(1, 0, 1).normalized(), left = Vec3(-1, 0, 1).normalized();
  const auto largest = [](const std::vector<Vec3>& directions, const Vec3& at) {
    const auto shares = ScatteredDirections(directions).shares(at);
    return std::ranges::max_element(shares, {}, &ScatteredDirections::Share::weight)->index;
  };
  EXPECT_EQ(largest({zenith}, right), 0);
  EXPECT_EQ(largest({zenith, right}, Vec3(1, 0.2, 0.1).normalized()), 1);
  EXPECT_EQ(largest({zenith, right, left}, Vec3(-0.9, 0.2, 0.3).normalized()), 2);
  EXPECT_EQ(largest({right, right, left, Vec3(0, 1, 0)}, right), 0);
}

TEST(ScatteredDirections, TellsTheirLargestGap) {
  const std::vector<Vec3> zenith = {Vec3(0, 0, 1)};
  EXPECT_NEAR(transport::largestGap(zenith).angle_rad, kPi / 2, 0.02);
  std::vector<Vec3> directions;
  for (const BtfDirection& angle : formats::directions151()) directions.push_back(vectorOf(angle));
  // On the horizon, midway between two of the outermost ring.
  const double expected = std::acos(std::sin(75 * kPi / 180) * std::cos(7.5 * kPi / 180));
  EXPECT_NEAR(transport::largestGap(directions).angle_rad, expected, 0.01);
}

TEST(BtfCrop, AveragesTexels) {
  MadeBtf made = measured(formats::directions81(), kHalfLambert, 7, 5);
  made.views.resize(2), made.lights.resize(3);
  made.value = [](const BtfDirection& view, const BtfDirection& light, int texel) {
    const double value = texel % 7 + 10 * (texel / 7) + 100 * view.polar_rad + light.polar_rad;
    return std::array<double, 3>{value, 2 * value, 0};
  };
  int dropped = 0;
  const auto part =
      cropped(btfOf(made), {.left = 1, .top = 1, .width = 5, .height = 4, .shrink = 2}, &dropped);
  EXPECT_EQ(part->info().width, 2);
  EXPECT_EQ(part->info().height, 2);
  EXPECT_EQ(dropped, 4);
  const std::vector<float> values = formats::decoded(*part);
  // Columns 1, 2 and 3, 4; rows 1, 2 and 3, 4.
  EXPECT_NEAR(values[0], 1.5 + 15, 1e-4);
  EXPECT_NEAR(values[3], 3.5 + 15, 1e-4);
  EXPECT_NEAR(values[6], 1.5 + 35, 1e-4);
  EXPECT_NEAR(values[7], 2 * (1.5 + 35), 1e-4);
  EXPECT_NEAR(values[12], 16.5 + made.lights[1].polar_rad, 1e-4) << "the second light";
  // In pieces that begin and end within rows.
  const std::vector<int> lights = {0, 1, 2};
  std::vector<float> piece(3 * 3 * 2);
  part->view(0)->decode(lights, {1, 2}, piece);
  EXPECT_NEAR(piece[0], 18.5, 1e-4);
  EXPECT_NEAR(piece[1], 36.5, 1e-4);
  EXPECT_THROW(cropped(btfOf(made), {.left = 7}), Error);
  EXPECT_THROW(cropped(btfOf(made), {.shrink = 6}), Error);
}

}  // namespace
}  // namespace bakelight::btf
