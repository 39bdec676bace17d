// Media, meshes and units that are extreme.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>

#include "formats/error.h"
#include "formats/part_tensors.h"
#include "tests/support/plate.h"
#include "transport/translucent_response.h"

namespace bakelight::kernels {
namespace {

using transport::TranslucentResponse;

constexpr int kTexels = 48;

std::vector<formats::Float3> evenResponse(const formats::Translucency& translucency) {
  const TranslucentResponse response(translucency);
  return response.respond(std::vector<formats::Float3>(response.texelCount(), {1, 1, 1}));
}

// From a hundredth of a texel to twenty times the plate, where factors are too faint for half floats as they are.
TEST(Stiff, AnyMeanFreePathGivesWhatTheIntegralGives) {
  const auto mesh = tests::plateMesh(kTexels, 4.4);
  for (const double path : {0.01, 0.1, 1.0, 10.0, 440.0, 1000.0}) {
    const auto medium = tests::mediumOf(path, 0.99);
    const Made made = tests::kernelsOf(mesh, kTexels, medium);
    const auto colors = reflectanceOf(medium);
    const auto radiosity = evenResponse(made.translucency);
    const auto texels = formats::wordsOf(made.translucency.texels),
               receivers = formats::wordsOf(made.translucency.receivers);
    double checked = 0;
    for (std::size_t r = 0; r < receivers.size(); ++r) {
      for (const float value : radiosity[r]) ASSERT_TRUE(std::isfinite(value)) << path;
      const std::uint32_t place = texels[receivers[r]];
      const double x = place % kTexels + 0.5, y = place / kTexels + 0.5;
      if (std::hypot(x - kTexels / 2, y - kTexels / 2) > 8) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        double expected = 0;
        for (int v = 2; v < kTexels - 2; ++v)
          for (int u = 2; u < kTexels - 2; ++u)
            expected += path < 1 ? 0 : colors[c](std::hypot(u + 0.5 - x, v + 0.5 - y));
        if (path < 1) expected = colors[c].total();
        EXPECT_NEAR(radiosity[r][c] / expected, 1, path > 100 ? 0.002 : 0.015)
            << path << " at " << x << " " << y;
      }
      ++checked;
    }
    EXPECT_GT(checked, 100);
  }
}

TEST(Stiff, MediaAtTheirLimitsAreRight) {
  const auto mesh = tests::plateMesh(kTexels, 4.4);
  for (const auto model : {formats::DiffusionModel::kDipole, formats::DiffusionModel::kBetterDipole,
                           formats::DiffusionModel::kNormalizedDiffusion})
    for (const double eta : {1.0, 1.3, 3.0})
      for (const float absorption : {0.0F, 1e-9F, 0.5F}) {
        formats::Medium medium;
        medium.model = model;
        medium.eta = eta;
        medium.absorption = {absorption, absorption, absorption};
        const Made made = tests::kernelsOf(mesh, kTexels, medium);
        double sum = 0;
        for (const auto& b : evenResponse(made.translucency)) {
          ASSERT_TRUE(std::isfinite(b[0]));
          sum += static_cast<double>(b[0]) / static_cast<double>(made.translucency.receiverCount());
        }
        const double total = reflectanceOf(medium)[0].total();
        EXPECT_GT(sum, 0.35 * total) << eta << " "
                                     << absorption;  // what leaves by the edges of the plate is lost
        EXPECT_LT(sum, 1.02 * total) << eta << " " << absorption;
      }
}

// Twice the same surface: each side sends to the other what it sends to itself.
TEST(Stiff, CoincidentSheetsGiveTwice) {
  auto mesh = tests::plateMesh(kTexels, 4.4);
  auto other = tests::plateMesh(kTexels, 4.4, 1e-3);
  const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
  for (auto& uv : mesh.texcoords) uv[0] /= 2, uv[1] = (1 + uv[1]) / 2;
  for (auto& uv : other.texcoords) uv[0] = (1 + uv[0]) / 2, uv[1] = (1 + uv[1]) / 2;
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  mesh.texcoords.insert(mesh.texcoords.end(), other.texcoords.begin(), other.texcoords.end());
  for (const auto& t : other.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  const auto medium = tests::mediumOf(2.5, 0.9);
  const Made made = tests::kernelsOf(mesh, 2 * kTexels, medium);
  EXPECT_GT(made.figures.apart_pairs, 100U);
  const double total = reflectanceOf(medium)[0].total();
  const auto radiosity = evenResponse(made.translucency);
  const auto texels = formats::wordsOf(made.translucency.texels),
             receivers = formats::wordsOf(made.translucency.receivers);
  std::size_t checked = 0;
  for (std::size_t r = 0; r < receivers.size(); ++r) {
    const std::uint32_t place = texels[receivers[r]];
    const double x = place % (2 * kTexels) % kTexels + 0.5, y = place / (2 * kTexels) + 0.5;
    if (std::hypot(x - kTexels / 2, y - kTexels / 2) > 6) continue;
    EXPECT_NEAR(radiosity[r][0] / (2 * total), 1, 0.03) << x << " " << y;
    ++checked;
  }
  EXPECT_GT(checked, 100U);
  EXPECT_GT(made.figures.touching_knots, 50U);
}

// Numbers do not depend on the unit of length.
TEST(Stiff, UnitsChangeNothing) {
  const auto mesh = tests::plateMesh(kTexels, 4.4);
  const Made made = tests::kernelsOf(mesh, kTexels, tests::mediumOf(2.5));
  for (const float scale : {1e-3F, 1e3F}) {
    auto scaled = mesh;
    for (auto& p : scaled.positions)
      for (float& x : p) x *= scale;
    auto medium = tests::mediumOf(2.5);
    medium.unit_mm = 1 / static_cast<double>(scale);
    const Made other = tests::kernelsOf(scaled, kTexels, medium);
    const auto expected = evenResponse(made.translucency), found = evenResponse(other.translucency);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t r = 0; r < found.size(); ++r)
      EXPECT_NEAR(found[r][1], expected[r][1], 2e-3F * expected[r][1]) << scale;
  }
}

// Two triangles, and next to no texels: weights that nothing determines are the least ones.
TEST(Stiff, FewTexelsAreNoFault) {
  const Made made = tests::kernelsOf(tests::plateMesh(8, 100), 8, tests::mediumOf(1));
  EXPECT_GT(made.figures.rank_deficient, 0U);
  for (const auto& b : evenResponse(made.translucency))
    for (const float value : b) EXPECT_TRUE(std::isfinite(value) && value >= 0 && value < 1.5F) << value;
}

TEST(Stiff, ThreadsChangeNoByte) {
  const auto mesh = tests::plateMesh(kTexels, 4.4);
  const auto bytesOf = [&] {
    formats::PackPart part(tests::kernelsOf(mesh, kTexels, tests::mediumOf(2.5)).translucency);
    return formats::encodeSafetensors(formats::tensorsOf(part));
  };
  const auto all = bytesOf();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(bytesOf(), all);
}

// Where the surface goes on in another chart, nothing shows.
TEST(Stiff, ChartsThatMeetGiveWhatOneChartGives) {
  constexpr int kSide = kTexels + 16;
  const auto medium = tests::mediumOf(2.0);
  const auto lit = [](const formats::Translucency& translucency, int side, bool cut) {
    std::map<std::pair<int, int>, float> found;  // by place on the plate
    const auto texels = formats::wordsOf(translucency.texels);
    const auto columnOf = [&](std::uint32_t place) {
      const int column = static_cast<int>(place) % side;
      return cut && column > kTexels / 2 + 6 ? column - 12 : column;
    };
    std::vector<formats::Float3> entering;
    for (const std::uint32_t place : texels) {
      const float value = columnOf(place) > kTexels / 2 + 3 ? 1 : 0.2F;
      entering.push_back({value, value, value});
    }
    const auto areas = translucency.areas.decode();
    const TranslucentResponse response(translucency);
    const auto radiosity = response.respond(entering);
    const auto receivers = formats::wordsOf(translucency.receivers);
    for (std::size_t r = 0; r < receivers.size(); ++r) {
      const std::uint32_t place = texels[receivers[r]];
      if (areas[receivers[r]] > 0.9F * areas[texels.size() / 3])
        found[{columnOf(place), static_cast<int>(place) / side}] = radiosity[r][0];
    }
    return found;
  };
  const auto whole =
      lit(tests::kernelsOf(tests::plateMesh(kTexels, 4.4), kTexels, medium).translucency, kTexels, false);
  const auto cut =
      lit(tests::kernelsOf(tests::cutPlateMesh(kTexels, 4.4), kSide, medium).translucency, kSide, true);
  const double total = reflectanceOf(medium)[0].total();
  std::size_t near_cut = 0;
  for (const auto& [place, radiosity] : cut) {
    const auto other = whole.find(place);
    if (other == whole.end() || place.second < 8 || place.second > kTexels - 9) continue;
    EXPECT_NEAR(radiosity, other->second, 0.02 * total) << place.first << " " << place.second;
    near_cut += std::abs(place.first - kTexels / 2) < 4;
  }
  EXPECT_GT(near_cut, 100U);
}

TEST(Stiff, MapsWithoutABorderAreRefusedWhereChartsMeet) {
  const auto mesh = tests::cutPlateMesh(kTexels, 4.4);
  for (const int border : {0, 3}) {
    const tests::TemporaryFolder folder;
    tests::writeMaps(mesh, kTexels + 16, folder / "maps.exr", border);
    try {
      makeTranslucency(mesh, folder / "maps.exr", tests::mediumOf(1), {}, stage::ProgressStyle::kNone);
      ADD_FAILURE() << border;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(border == 0 ? "nothing" : "3 texels"));
      EXPECT_THAT(error.what(), testing::HasSubstr("--border 4"));
    }
  }
}

TEST(Stiff, MapsOfAnotherMeshAreRefused) {
  const tests::TemporaryFolder folder;
  tests::writeMaps(tests::plateMesh(kTexels, 4.4), kTexels, folder / "maps.exr");
  EXPECT_THROW(makeTranslucency(tests::plateMesh(kTexels, 3.9), folder / "maps.exr", tests::mediumOf(1), {},
                                stage::ProgressStyle::kNone),
               Error);
}

}  // namespace
}  // namespace bakelight::kernels
