// Media that vary: veins are where and as wide as asked, and ways through them have what there is along them.
#include "transport/medium_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>

namespace bakelight::transport {
namespace {

const std::vector<Float3> kBox = {{-1, -1, -1}, {1, 1, 1}};

formats::Medium veined(double spacing, double width, int seed = 0) {
  formats::Medium medium{{2, 3, 4}, {0.01F, 0.02F, 0.03F}, 1.4, 1, {}};
  medium.veins = formats::Veins{{1, 1, 1}, {0.3F, 0.4F, 0.5F}, spacing, width, seed};
  return medium;
}

// Of the box's volume.
template <class Function>
double mean(const Function& function, int count = 40, double half = 1) {
  double sum = 0;
  for (int z = 0; z < count; ++z)
    for (int y = 0; y < count; ++y)
      for (int x = 0; x < count; ++x)
        sum += function(half * ((Vec3(x, y, z) + Vec3::Constant(0.5)) * 2 / count - Vec3::Ones()));
  return sum / count / count / count;
}

TEST(MediumField, WithoutVeinsIsOneMedium) {
  formats::Medium medium = veined(1, 0.1);
  medium.veins.reset();
  const MediumField field(medium, kBox);
  EXPECT_TRUE(field.isUniform());
  ASSERT_EQ(field.reflectances().size(), 1U);
  const MediumField::Place way = field.along(Vec3(0, 0, 0), Vec3(1, 0, 0));
  EXPECT_EQ(field.reflectance(1, 0.7, way), field.reflectances()[0][1](0.7));
  EXPECT_EQ(field.shareAt(Vec3::Zero()), 0);
  EXPECT_EQ(field.coefficients(2, 0).extinction(), 4 + double{0.03F});
}

// Sheets: twice as wide is twice the volume; the width is where half is theirs.
TEST(MediumField, VeinsAreAsWideAsAsked) {
  const auto halves = [](double width) {
    const std::vector<Float3> small = {{-0.5F, -0.5F, -0.5F}, {0.5F, 0.5F, 0.5F}};
    const MediumField field(veined(0.4, width), small);
    return mean([&](const Vec3& p) { return field.shareAt(p) >= 0.5 ? 1.0 : 0.0; }, 60, 0.5);
  };
  const double narrow = halves(0.025), wide = halves(0.05);
  EXPECT_NEAR(wide / narrow, 2, 0.15);
  // Area of the sheets per volume, by Rice's formula for slopes of all directions: 2 · mean slope · density of the height 0. The noise's, measured: mean slope
  // 2.55, root mean square of the height 0.34, nearly normal.
  const double area = 2.55 / 0.4 / (0.342 * std::sqrt(2 * std::numbers::pi));
  EXPECT_NEAR(narrow / 0.025 / area, 1, 0.25);
}

TEST(MediumField, SeedsPutVeinsElsewhere) {
  const MediumField one(veined(0.6, 0.1, 1), kBox), other(veined(0.6, 0.1, 2), kBox),
      same(veined(0.6, 0.1, 1), kBox);
  EXPECT_GT(mean([&](const Vec3& p) { return std::abs(one.shareAt(p) - other.shareAt(p)); }), 0.1);
  EXPECT_EQ(mean([&](const Vec3& p) { return std::abs(one.shareAt(p) - same.shareAt(p)); }), 0);
}

// The mean of what lies on its line, more or less: it is that of a tube.
TEST(MediumField, WaysHaveWhatLiesAlongThem) {
  const MediumField field(veined(0.6, 0.1), kBox);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-1, 1);
  double products = 0, tube_squares = 0, line_squares = 0, both = 0, lines = 0;
  constexpr int kWays = 400, kPoints = 200;
  const auto shareOf = [&](const MediumField::Place& way) {  // nodes are squares
    const double low = way.node[0] / (MediumField::kNodes - 1.0),
                 high = (way.node[0] + 1) / (MediumField::kNodes - 1.0);
    return low * low + static_cast<double>(way.share[0]) * (high * high - low * low);
  };
  for (int i = 0; i < kWays; ++i) {
    const Vec3 from(place(random), place(random), place(random));
    const Vec3 to = from + 0.3 * Vec3(place(random), place(random), place(random));
    double line = 0;
    for (int k = 0; k < kPoints; ++k)
      line += field.shareAt(from + (k + 0.5) / kPoints * (to - from)) / kPoints;
    const MediumField::Place way = field.along(from, to), back = field.along(to, from);
    EXPECT_NEAR(shareOf(way), shareOf(back), 1e-5);
    const double tube = shareOf(way);
    both += tube, lines += line;
    products += tube * line, tube_squares += tube * tube, line_squares += line * line;
  }
  EXPECT_NEAR(both / lines, 1, 0.03);
  const double n = kWays, covariance = products / n - both / n * lines / n;
  EXPECT_GT(covariance / std::sqrt((tube_squares / n - both / n * both / n) *
                                   (line_squares / n - lines / n * lines / n)),
            0.9);
}

TEST(MediumField, SharesMixCoefficients) {
  const MediumField field(veined(0.6, 0.1), kBox);
  EXPECT_NEAR(field.coefficients(0, 0.25).reduced_scattering, 1.75, 1e-6);
  EXPECT_NEAR(field.coefficients(0, 0.25).absorption, 0.01 + 0.25 * 0.29, 1e-6);
  const DiffuseReflectance mixed(formats::DiffusionModel::kDipole, field.coefficients(1, 0.3));
  EXPECT_NEAR(field.reflectance(1, 0.4, MediumField::placeOf(0.3)) / mixed(0.4), 1, 0.02);
  for (const double share : {0.0, 1.0})
    EXPECT_EQ(field.reflectance(1, 0.4, MediumField::placeOf(share)),
              DiffuseReflectance(formats::DiffusionModel::kDipole, field.coefficients(1, share))(0.4));
}

TEST(MediumField, TurnsWithItsObject) {
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  const Eigen::Isometry3d here_from_object = Eigen::Translation3d(0.1, 0.2, 0.3) * turn;
  std::vector<Float3> turned;
  for (const Float3& corner : kBox) turned.push_back(float3(here_from_object * vec3(corner)));
  const MediumField field(veined(0.6, 0.1), kBox);
  const MediumField moved(veined(0.6, 0.1), turned, here_from_object.inverse());
  EXPECT_LT(
      mean([&](const Vec3& p) { return std::abs(field.shareAt(p) - moved.shareAt(here_from_object * p)); }),
      1e-5);
}

TEST(MediumField, ThinnerVeinsThanCellsAreRefused) {
  EXPECT_NO_THROW(MediumField(veined(0.5, 0.1), kBox));
  EXPECT_THROW(MediumField(veined(0.5, 0.002), kBox), std::invalid_argument);
}

// A square of 2 × 2 in the plane z = 0, of some colors along x.
struct Colored {
  formats::TriangleMesh mesh;
  explicit Colored(const std::vector<Float3>& columns) {
    for (std::size_t i = 0; i < columns.size(); ++i)
      for (const float y : {-1.0F, 1.0F}) {
        mesh.positions.push_back(
            {2 * static_cast<float>(i) / static_cast<float>(columns.size() - 1) - 1, y, 0});
        mesh.colors.push_back(columns[i]);
      }
    for (std::uint32_t i = 0; i + 2 < mesh.vertexCount(); i += 2) {
      mesh.triangles.push_back({i, i + 2, i + 3});
      mesh.triangles.push_back({i, i + 3, i + 1});
    }
  }
};

formats::Medium ofAlbedo(formats::DiffusionModel model = formats::DiffusionModel::kDipole) {
  formats::Medium medium;
  medium.reduced_scattering = {20, 30, 40};
  medium.absorption = {0, 1, 2};
  medium.reflectance = formats::ReflectanceSource::kAlbedo;
  medium.model = model;
  return medium;
}

TEST(FieldOfAlbedo, OneColorIsTheUniformMedium) {
  const Colored square({{0.3F, 0.5F, 0.9F}, {0.3F, 0.5F, 0.9F}});
  const MediumField field(ofAlbedo(), square.mesh);
  EXPECT_TRUE(field.isUniform());
  EXPECT_FALSE(field.isOfSurface());
  for (std::size_t c = 0; c < 3; ++c) {
    const ScatteringCoefficients own = coefficientsOfReflectance(
        formats::DiffusionModel::kDipole, static_cast<double>(square.mesh.colors[0][c]),
        field.coefficients(c, 0).extinction(), 1.3);
    const DiffuseReflectance expected(formats::DiffusionModel::kDipole, own);
    EXPECT_EQ(field.reflectance(c, 0.3, {}), expected(0.3));
    EXPECT_NEAR(expected.total(), static_cast<double>(square.mesh.colors[0][c]), 1e-9);
  }
}

// R_d between nodes, against the medium that is meant.
TEST(FieldOfAlbedo, InterpolatesReflectances) {
  for (const auto model : {formats::DiffusionModel::kDipole, formats::DiffusionModel::kBetterDipole,
                           formats::DiffusionModel::kNormalizedDiffusion}) {
    const Colored square({{0, 0, 0}, {1, 1, 1}});
    const MediumField field(ofAlbedo(model), square.mesh);
    ASSERT_TRUE(field.isOfSurface());
    EXPECT_EQ(field.reflectances().size(), MediumField::kReflectanceNodes);
    double worst = 0;
    for (double reflectance = 0.002; reflectance < 1; reflectance += 0.0137) {
      MediumField::Surroundings here;
      here.fill(Eigen::Array3f::Constant(static_cast<float>(reflectance)));
      const MediumField::Place place = field.along(here, here, 0.1);
      const DiffuseReflectance exact(
          model, coefficientsOfReflectance(model, reflectance, field.coefficients(0, 0).extinction(), 1.3));
      double error = 0, total = 0, before = 0;
      for (double r = 1e-4; r < 100; r *= 1.02) {  // rings
        const double area = std::numbers::pi * (r * r - before * before), middle = (r + before) / 2;
        error += area * std::abs(field.reflectance(0, middle, place) - exact(middle));
        total += area * field.reflectance(0, middle, place);
        before = r;
      }
      worst = std::max(worst, error / reflectance);
      EXPECT_NEAR(total / exact.enclosed(before), 1, 2e-3) << reflectance;
    }
    EXPECT_LT(worst, 0.01) << static_cast<int>(model);
    RecordProperty("worst", std::to_string(worst));
  }
}

TEST(FieldOfAlbedo, EndsHaveWhatIsAroundThemAsFarAsTheyAreApart) {
  const Colored square({{0.2F, 0.5F, 0.5F}, {0.2F, 0.5F, 0.5F}, {0.8F, 0.5F, 0.5F}, {0.8F, 0.5F, 0.5F}});
  const MediumField field(ofAlbedo(), square.mesh);
  const Vec3 left(-0.9, 0, 0), right(0.9, 0.1, 0);
  const auto at = [&](const Vec3& point, float own) { return field.surroundings(point, {own, 0.5F, 0.5F}); };
  const auto near = at(left, 0.2F), far = at(right, 0.8F);
  // Each its own where it is alike all around, half of all where that is the whole.
  for (std::size_t scale = 0; scale < 4; ++scale) {
    EXPECT_NEAR(near[scale][0], 0.2, 1e-5);
    EXPECT_NEAR(far[scale][0], 0.8, 1e-5);
    EXPECT_NEAR(near[scale][1], 0.5, 1e-5);
  }
  EXPECT_NEAR(near.back()[0], 0.5, 0.02);
  EXPECT_NEAR(far.back()[0], 0.5, 0.02);
  // The same either way.
  for (const double distance : {0.0, 1e-3, 0.04, 0.3, 1.8, 50.0})
    for (std::size_t c = 0; c < 3; ++c) {
      const auto one = field.along(near, far, distance), other = field.along(far, near, distance);
      EXPECT_EQ(one.node[c], other.node[c]);
      EXPECT_EQ(one.share[c], other.share[c]);
    }
  // R_d of the mean, of each color.
  const DiffuseReflectance mean(formats::DiffusionModel::kDipole,
                                coefficientsOfReflectance(formats::DiffusionModel::kDipole, 0.5, 20, 1.3));
  EXPECT_NEAR(field.reflectance(0, 0.1, field.along(near, far, 0.01)) / mean(0.1), 1, 0.01);
}

TEST(FieldOfAlbedo, TurnsWithItsObject) {
  const Colored square({{0.2F, 0.5F, 0.5F}, {0.8F, 0.5F, 0.5F}, {0.3F, 0.9F, 0.1F}});
  const Eigen::Isometry3d here_from_object =
      Eigen::Translation3d(0.1, 0.2, 0.3) *
      Eigen::Isometry3d(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  Colored turned = square;
  for (Float3& corner : turned.mesh.positions) corner = float3(here_from_object * vec3(corner));
  const MediumField field(ofAlbedo(), square.mesh),
      moved(ofAlbedo(), turned.mesh, here_from_object.inverse());
  for (const Vec3& point : {Vec3(0.1, 0.2, 0), Vec3(-0.7, 0.9, 0), Vec3(1, 1, 0)}) {
    const auto one = field.surroundings(point, {0.4F, 0.4F, 0.4F}),
               other = moved.surroundings(here_from_object * point, {0.4F, 0.4F, 0.4F});
    for (std::size_t scale = 0; scale < one.size(); ++scale)
      EXPECT_LT((one[scale] - other[scale]).abs().maxCoeff(), 2e-3) << scale;
  }
}

TEST(FieldOfAlbedo, ReflectancesOutOfReachAreClampedAndNoneIsRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Colored wide({{-1, 0, 0}, {7, 1, 1}});
  const MediumField field(ofAlbedo(), wide.mesh);
  EXPECT_NEAR(field.reflectances().front()[0].total(), static_cast<double>(MediumField::kLeastReflectance),
              1e-8);
  EXPECT_NEAR(field.reflectances().back()[0].total(), 1, 1e-12);
  const Colored bad({{0.5F, nan, 0.5F}, {0.5F, 0.5F, 0.5F}});
  EXPECT_THROW(MediumField(ofAlbedo(), bad.mesh), std::invalid_argument);
  formats::TriangleMesh colorless = wide.mesh;
  colorless.colors.clear();
  EXPECT_THROW(MediumField(ofAlbedo(), colorless), std::invalid_argument);
  EXPECT_THROW(MediumField(ofAlbedo(), kBox), std::invalid_argument);
}

}  // namespace
}  // namespace bakelight::transport
