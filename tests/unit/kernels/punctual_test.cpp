// Punctual lights on the texels of a translucent object.
#include <gtest/gtest.h>

#include "formats/error.h"
#include "tests/support/made_translucent_pack.h"
#include "tests/support/shapes.h"
#include "transport/near_light.h"
#include "transport/surface_points.h"
#include "transport/texel_irradiance.h"
#include "transport/translucent_shading.h"

namespace bakelight::transport {
namespace {

constexpr int kTexels = 64;
constexpr double kEta = 1.3;

formats::Pack plate(int order = 1) {
  formats::Medium medium = tests::mediumOf(2.5);
  medium.eta = kEta;
  return tests::translucentPack(kTexels, medium, order, 0);
}

const formats::Translucency& translucencyOf(const formats::Pack& pack) {
  return *pack.appearances.at(0).reflection.as<formats::Translucency>();
}

PlacedPunctualLight pointAt(const Vec3& position) {
  PlacedPunctualLight light;
  light.position = position;
  light.intensity = {4000, 2000, 1000};
  return light;
}

// Square holes in a roof of unit squares.
PlacedPunctualLight checkerboardAbove(double height, int squares, double width) {
  auto image = std::make_shared<formats::Image>(squares, squares, std::vector<std::string>{"R", "G", "B"});
  for (int y = 0; y < squares; ++y)
    for (int x = 0; x < squares; ++x)
      for (int c = 0; c < 3; ++c) image->texel(x, y)[c] = (x + y) % 2 == 0 ? 1 : 0;
  PlacedPunctualLight slide = pointAt({(kTexels - 4) / 2.0, height, (kTexels - 4) / 2.0});
  slide.type = PlacedPunctualLight::Type::kSlide;
  slide.axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // down; right is +x, up is −z
  slide.half_width = slide.half_height = width / 2 / height;
  slide.image = image;
  return slide;
}

const Occlusion kNothing = [](const Vec3&, const Vec3&, double) { return false; };

double enteringAt(const PlacedPunctualLight& light, double x, double z, std::size_t color) {
  const Vec3 way = light.position - Vec3(x, 0, z);
  const double cosine = way.normalized().y();
  return light.irradianceFacing({x, 0, z})[static_cast<Eigen::Index>(color)] * cosine *
         schlickTransmittance(cosine, kEta);
}

// Rows and columns of a texel are x and z of the plate, less its margin.
std::pair<double, double> middleOf(std::uint32_t place) {
  return {place % kTexels + 0.5 - 2, place / kTexels + 0.5 - 2};
}

bool isInner(std::pair<double, double> middle) {
  return std::min(middle.first, middle.second) > 1 && std::max(middle.first, middle.second) < kTexels - 5;
}

TEST(TexelIrradiance, OfAPointLightIsThatOfThePlane) {
  const formats::Pack pack = plate();
  const TexelIrradiance texels(translucencyOf(pack), pack.mesh);
  const PlacedPunctualLight light = pointAt({10, 20, 15});
  const std::vector<Float3> entering = texels.entering(std::span(&light, 1), shadowsOf(pack.mesh));
  const auto places = formats::wordsOf(translucencyOf(pack).texels);
  ASSERT_EQ(entering.size(), places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, z] = middleOf(places[i]);
    if (!isInner({x, z})) continue;
    EXPECT_NEAR(entering[i][1] / enteringAt(light, x, z, 1), 1, 0.01) << x << ' ' << z;
  }
  const PlacedPunctualLight below = pointAt({10, -20, 15});
  for (const Float3& texel : texels.entering(std::span(&below, 1), kNothing)) EXPECT_EQ(texel[0], 0);
}

// Texels that an edge goes through get their share: the sum over squares is right, and no texel is far from its mean.
TEST(TexelIrradiance, EdgesOfSlidesAreSharedOut) {
  const formats::Pack pack = plate();
  const TexelIrradiance texels(translucencyOf(pack), pack.mesh);
  const PlacedPunctualLight slide = checkerboardAbove(100, 7, 33.3);
  const std::vector<Float3> entering = texels.entering(std::span(&slide, 1), kNothing);
  const auto places = formats::wordsOf(translucencyOf(pack).texels);
  double worst = 0, sum = 0, expected_sum = 0, most = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, z] = middleOf(places[i]);
    if (!isInner({x, z})) continue;
    double expected = 0;
    constexpr int kParts = 32;
    for (int a = 0; a < kParts; ++a)
      for (int b = 0; b < kParts; ++b)
        expected += enteringAt(slide, x + (a + 0.5) / kParts - 0.5, z + (b + 0.5) / kParts - 0.5, 0) /
                    (kParts * kParts);
    worst = std::max(worst, std::abs(static_cast<double>(entering[i][0]) - expected));
    most = std::max(most, expected);
    sum += static_cast<double>(entering[i][0]), expected_sum += expected;
  }
  EXPECT_LT(worst, 0.16 * most);
  EXPECT_NEAR(sum / expected_sum, 1, 0.002);
}

// What lies between hides the light, and nothing else does.
TEST(TexelIrradiance, ShadowsAreThoseOfTheMesh) {
  const formats::Pack pack = plate();
  const TexelIrradiance texels(translucencyOf(pack), pack.mesh);
  const PlacedPunctualLight light = pointAt({30, 40, 30});
  formats::TriangleMesh with_lid = pack.mesh;
  const auto first = static_cast<std::uint32_t>(with_lid.vertexCount());
  for (const auto& [x, z] : {std::pair(25.F, 25.F), {35.F, 25.F}, {35.F, 35.F}, {25.F, 35.F}})
    with_lid.positions.push_back({x, 20, z});
  with_lid.triangles.push_back({first, first + 1, first + 2});
  with_lid.triangles.push_back({first, first + 2, first + 3});
  const std::vector<Float3> entering = texels.entering(std::span(&light, 1), shadowsOf(with_lid));
  const auto places = formats::wordsOf(translucencyOf(pack).texels);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, z] = middleOf(places[i]);
    const double away = std::max(std::abs(x - 30), std::abs(z - 30));
    if (!isInner({x, z}) || std::abs(away - 10) < 0.75) continue;
    EXPECT_NEAR(entering[i][0] / enteringAt(light, x, z, 0), away < 10 ? 0 : 1, 0.01) << x << ' ' << z;
  }
}

// A coarse ball with smooth normals is lit as a ball is: by the cosine up to where it turns away, without a triangle in the dark.
TEST(SmoothPoint, OfACoarseBallIsNotInItsOwnShadow) {
  const formats::TriangleMesh ball = tests::icosphere(2);
  const Occlusion shadows = shadowsOf(ball);
  const Vec3 light(0.3, 5, 0.4);
  int lit = 0;
  for (std::uint32_t t = 0; t < ball.triangleCount(); ++t)
    for (const auto& [u, v] : {std::pair(0.1, 0.1), {0.4, 0.4}, {0.8, 0.1}, {0.1, 0.8}, {1.2, -0.1}}) {
      const SmoothPoint point = smoothPoint(ball, t, u, v);
      const Vec3 origin = point.lifted + 1e-4 * point.normal, way = light - origin;
      EXPECT_NEAR(point.normal.norm(), 1, 1e-9);
      if (point.normal.dot(way) <= 0) continue;
      ++lit;
      EXPECT_FALSE(shadows(origin, way.normalized(), way.norm())) << t << ' ' << u << ' ' << v;
    }
  EXPECT_GT(lit, 500);
}

TEST(TranslucentShading, PunctualLightsComeOnTopAndGo) {
  const formats::Pack pack = plate();
  TranslucentShading shading(pack);
  EXPECT_TRUE(shading.needs().punctual);
  const std::vector<Float3> sky(1, Float3{1, 1, 1});
  const auto radiosity = [&](std::span<const PlacedPunctualLight> lights, bool with_sky) {
    shading.setPunctualLights(lights, kNothing);
    shading.setLight(with_sky ? sky : std::vector<Float3>(1, Float3{0, 0, 0}), {});
    return std::vector<formats::Float4>(shading.radiosity().begin(), shading.radiosity().end());
  };
  const PlacedPunctualLight light = pointAt({30, 30, 30});
  const auto neither = radiosity({}, false), both = radiosity(std::span(&light, 1), true),
             only_sky = radiosity({}, true), only_light = radiosity(std::span(&light, 1), false);
  float most = 0;
  for (std::size_t i = 0; i < both.size(); ++i) {
    EXPECT_EQ(neither[i][0], 0);
    EXPECT_NEAR(both[i][0], only_sky[i][0] + only_light[i][0], 1e-5F * (1 + both[i][0]));
    most = std::max(most, only_light[i][0]);
  }
  EXPECT_GT(most, 0.5F);
}

// Squares of 4.4 texels, on a plate of a mean free path of 2.5: radiosity against the integral over the plate, by parts of a texel.
TEST(TranslucentShading, ASlideComesOutAsTheIntegralSays) {
  formats::Medium medium = tests::mediumOf(2.5);
  medium.eta = kEta;
  const formats::Pack pack = plate();
  TranslucentShading shading(pack);
  const PlacedPunctualLight slide = checkerboardAbove(100, 10, 44);
  shading.setPunctualLights(std::span(&slide, 1), kNothing);
  shading.setLight(std::vector<Float3>(1, Float3{0, 0, 0}), {});
  const DiffuseReflectance reflectance = kernels::reflectanceOf(medium)[0];
  constexpr int kParts = 4, kSide = (kTexels - 4) * kParts;
  std::vector<double> entering(static_cast<std::size_t>(kSide) * kSide);
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i)
      entering[static_cast<std::size_t>(j) * kSide + i] =
          enteringAt(slide, (i + 0.5) / kParts, (j + 0.5) / kParts, 0) / (kParts * kParts);
  double squares = 0, truth_squares = 0;
  for (int row = 20; row < 40; row += 3)
    for (int column = 20; column < 40; column += 3) {
      const double x = column + 0.5, z = row + 0.5;
      double truth = 0;
      for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i)
          if (const double light = entering[static_cast<std::size_t>(j) * kSide + i]; light > 0)
            truth += light * reflectance(std::hypot((i + 0.5) / kParts - x, (j + 0.5) / kParts - z));
      const formats::Float4& seen =
          shading.radiosity()[static_cast<std::size_t>(row + 2) * kTexels + column + 2];
      squares += std::pow(static_cast<double>(seen[0]) - truth, 2), truth_squares += truth * truth;
    }
  EXPECT_LT(std::sqrt(squares / truth_squares), 0.02);
}

TEST(TranslucentShading, TexelsOfPacksThatWereReorderedLieWhereTheyDid) {
  formats::Pack pack = plate();
  const PlacedPunctualLight slide = checkerboardAbove(100, 7, 33.3);
  const auto entering = [&](const formats::Pack& of) {
    return TexelIrradiance(translucencyOf(of), of.mesh).entering(std::span(&slide, 1), kNothing);
  };
  const std::vector<Float3> before = entering(pack);
  // Corners turn round, triangles change places.
  for (std::size_t t = 0; t < pack.mesh.triangleCount(); ++t)
    std::rotate(pack.mesh.triangles[t].begin(), pack.mesh.triangles[t].begin() + t % 3,
                pack.mesh.triangles[t].end());
  std::reverse(pack.mesh.triangles.begin(), pack.mesh.triangles.end());
  const std::vector<Float3> after = entering(pack);
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(after[i][0], before[i][0], 0.05F) << i;
  // Triangles that are gone leave texels without a place.
  pack.mesh.triangles.resize(pack.mesh.triangleCount() / 2);
  EXPECT_THROW(entering(pack), std::invalid_argument);
}

// What cannot take them says so with the rig's name; nothing is dropped in silence.
TEST(PackShading, RefusesPunctualLightsUnlessItTakesThem) {
  formats::LightRig rig;
  rig.punctual.resize(1);
  EXPECT_NO_THROW(requirePunctualTaken(rig, {.sh_order = 4, .punctual = true}, "rig.json"));
  EXPECT_NO_THROW(requirePunctualTaken({}, {.sh_order = 4}, "rig.json"));
  try {
    requirePunctualTaken(rig, {.sh_order = 4}, "rig.json");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.place().file, "rig.json");
    EXPECT_EQ(error.place().pointer, "/punctual");
  }
  formats::Pack pack = plate();
  pack.appearances.front().reflection = formats::LambertReflection{};
  const auto shading = makePackShading(pack);
  EXPECT_NO_THROW(shading->setPunctualLights({}, kNothing));
  const PlacedPunctualLight light;
  EXPECT_THROW(shading->setPunctualLights(std::span(&light, 1), kNothing), std::logic_error);
}

}  // namespace
}  // namespace bakelight::transport
