// BTFs of patches: closed forms, and beside the radiance transfer texture of the same patch.
#include "tools/rtt/directional.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "formats/btf_table.h"
#include "formats/json.h"
#include "formats/radiance_transfer_texture.h"
#include "tests/support/patches.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"
#include "tools/btf/projection.h"
#include "tools/rtt/light_basis.h"
#include "transport/btf_factorization.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::rtt {
namespace {

constexpr double kPi = std::numbers::pi;

Options small(int resolution, int views) {
  Options options;
  options.resolution = options.elements = resolution;
  options.views = views;
  return options;
}

DirectionalBtf rendered(const patch::PatchGeometry& geometry, const Options& options,
                        const BtfOptions& lights = {}) {
  return makeBtf(geometry, options, lights, "patch.btf", [] {});
}

std::vector<int> allLights(const formats::Btf& btf) {
  return btf.lightsOf(0);
}

// Of one view, as BtfView::decode has it.
std::vector<float> valuesOf(const formats::Btf& btf, int view) {
  std::vector<float> values(3 * btf.info().lights.size() * btf.texelCount());
  btf.view(view)->decode(allLights(btf), {0, btf.texelCount()}, values);
  return values;
}

double meanCosine(int side, int column, int row) {
  constexpr int kSteps = 64;
  double sum = 0;
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < kSteps; ++i)
      sum += transport::hemisphereFromSquare((column + (i + 0.5) / kSteps) / side,
                                             (row + (j + 0.5) / kSteps) / side)
                 .z();
  return sum / kSteps / kSteps;
}

// ρ/π · the cosine's mean over the cell: exact but on the square's diagonals, where it has an edge.
TEST(BtfOfAFlatPatch, IsTheMeanCosineOfTheCell) {
  const formats::Float3 albedo = {1, 0.5F, 0.25F};
  const DirectionalBtf made = rendered(tests::flatPatch(albedo), small(4, 3));
  const formats::Btf& btf = *made.btf;
  EXPECT_TRUE(btf.info().cosine_inside);
  ASSERT_EQ(btf.info().views.size(), 9U);
  ASSERT_EQ(btf.info().lights.size(), 64U);
  std::vector<double> cosines;
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) cosines.push_back(meanCosine(8, column, row));
  for (int view = 0; view < 9; ++view) {
    const std::vector<float> values = valuesOf(btf, view);
    for (std::size_t c = 0; c < 3; ++c)
      for (int row = 0; row < 8; ++row)
        for (int column = 0; column < 8; ++column) {
          const double white = albedo[c] / kPi,
                       right = white * cosines[static_cast<std::size_t>(row) * 8 + column];
          const bool is_diagonal = column == row || column + row == 7;
          const std::size_t light = static_cast<std::size_t>(row) * 8 + column;
          for (std::size_t t = 0; t < 16; ++t)
            ASSERT_NEAR(values[(c * 64 + light) * 16 + t], right, (is_diagonal ? 0.011 : 2e-6) * white)
                << view << ": " << column << ", " << row;
        }
  }
  EXPECT_NEAR(made.figures.mean_albedo[1], 0.5, 2e-3);
}

// Mirrors show the opposite cell, and only that: which way views and lights are numbered.
TEST(BtfOfAFlatMirror, IsTheOppositeCell) {
  patch::PatchGeometry geometry = tests::flatPatch({0, 0, 0});
  geometry.reflection = formats::GgxReflection{{1, 1, 1}, 0, false, false};
  const DirectionalBtf made = rendered(geometry, small(2, 8));
  for (int view = 0; view < 64; ++view) {
    const std::vector<float> values = valuesOf(*made.btf, view);
    for (int light = 0; light < 64; ++light)
      ASSERT_NEAR(values[static_cast<std::size_t>(light) * 4], light == 63 - view ? 1 / cellSolidAngle(8) : 0,
                  1e-4)
          << view << " " << light;
  }
}

// Light from all cells together, radiance × solid angle of each.
TEST(BtfFurnace, WhiteHeightFieldIsAsBrightAsItsSky) {
  for (const double depth : {0.05, 0.3, 1.5}) {
    const DirectionalBtf made = rendered(tests::heightPatch(24, depth, tests::waves), small(16, 4));
    double least = 1e9, most = 0;
    for (int view = 0; view < 16; ++view) {
      const std::vector<float> values = valuesOf(*made.btf, view);
      for (std::size_t t = 0; t < 256; ++t) {
        double sum = 0;
        for (std::size_t light = 0; light < 64; ++light) sum += cellSolidAngle(8) * values[light * 256 + t];
        least = std::min(least, sum), most = std::max(most, sum);
      }
    }
    EXPECT_GT(least, 0.98) << depth;
    EXPECT_LT(most, 1.02) << depth;
    EXPECT_NEAR(made.figures.mean_albedo[0], 1, 5e-3) << depth;
  }
}

struct Agreement {
  double difference = 0, albedo = 0;  // relative RMS of all coefficients; of those of a uniform sky
};
Agreement agreementWithTexture(const patch::PatchGeometry& geometry, const Options& options) {
  const formats::RadianceTransferTexture texture = makeRtt(geometry, options, [] {}).texture;
  const DirectionalBtf made = rendered(geometry, options);
  btf::ProjectionOptions projection;
  projection.views = options.views;
  const formats::RadianceTransferTexture projected = btf::project(*made.btf, projection).texture;
  EXPECT_EQ(projected.values.size(), texture.values.size());
  double squares = 0, differences = 0, first_squares = 0, first_differences = 0;
  for (std::size_t i = 0; i < texture.values.size(); ++i) {
    const double square = std::pow(texture.values[i], 2);
    const double difference = std::pow(projected.values[i] - texture.values[i], 2);
    squares += square, differences += difference;
    if (i % 25 == 0) first_squares += square, first_differences += difference;
  }
  return {std::sqrt(differences / squares), std::sqrt(first_differences / first_squares)};
}

// The tool btf interpolates between the middles of 64 cells, and takes the outermost beyond 76°: what 5 bands lose by that.
TEST(BtfOfASmoothPatch, ProjectsToItsTexture) {
  const formats::Float3 brown = {0.6F, 0.4F, 0.2F};
  const Agreement shallow =
      agreementWithTexture(tests::heightPatch(24, 0.05, tests::waves, brown), small(16, 4));
  EXPECT_LT(shallow.difference, 0.03);
  EXPECT_LT(shallow.albedo, 0.03);
  const Agreement deep = agreementWithTexture(tests::heightPatch(24, 0.3, tests::waves, brown), small(16, 4));
  EXPECT_LT(deep.difference, 0.06);
  EXPECT_LT(deep.albedo, 0.03);
}

TEST(DirectionalBtf, HasTheSameBytesWithAnyNumberOfThreads) {
  const patch::PatchGeometry geometry = tests::heightPatch(20, 0.4, tests::waves, {0.9F, 0.5F, 0.3F});
  std::vector<std::vector<float>> made;
  for (const std::size_t threads : {1, 2}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    made.push_back(valuesOf(*rendered(geometry, small(12, 2), {4, 2}).btf, 3));
  }
  EXPECT_EQ(made[0], made[1]);
}

class RttToolTest : public testing::Test {
 protected:
  tests::ShellOutcome run(const formats::Json& material, const std::string& options,
                          const std::string& sizes = "--resolution 8 --elements 8 --views 2") {
    std::ofstream(folder_ / "material.json") << material;
    return tests::shell(std::string(BAKELIGHT_BIN_DIR) + "/rtt --material '" + path("material.json") +
                        "' --progress none " + sizes + " --rtt '" + path("patch.exr") + "' --btf '" +
                        path("patch.btf") + "' --stats '" + path("stats.json") + "' " + options);
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  tests::TemporaryFolder folder_;
  const formats::Json dents_ = {
      {"patch", {{"height", {{"file", BAKELIGHT_SOURCE_DIR "/configs/patches/dents.png"}}}}}};
};

// One run, both files; what is written is what was rendered, within the error that is told.
TEST_F(RttToolTest, WritesBothTexturesOfOneRun) {
  for (const std::string layout : {"factorized", "raw"}) {
    const tests::ShellOutcome outcome = run(dents_, "--btf-lights 4 --btf-layout " + layout);
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    const formats::Json figures = formats::readJson(folder_ / "stats.json").at("stats").at("btfs").at(0);
    EXPECT_LT(figures.at("written_error"), layout == "raw" ? 5e-4 : 0.02);
    const auto btf = formats::openBtf(path("patch.btf"));
    EXPECT_EQ(btf->info().lights.size(), 16U);
    EXPECT_EQ(btf->info().views.size(), 4U);
    EXPECT_TRUE(btf->info().cosine_inside);
    EXPECT_EQ(formats::readRadianceTransferTextures(path("patch.exr")).front().views, 2);
  }
}

// As tables: of each material, and the values of its own .btf; what is measured is taken over.
TEST_F(RttToolTest, WritesBtfsOfAllMaterials) {
  const formats::Json stucco = {
      {"albedo", {0.3, 0.5, 0.7}},
      {"patch",
       {{"height", {{"file", BAKELIGHT_SOURCE_DIR "/configs/patches/stucco.png"}, {"depth", 0.3}}}}}};
  const std::string tables = path("btfs.safetensors");
  ASSERT_EQ(run(stucco, "--btf-lights 4 --btf-layout raw").status, 0);
  const auto alone = formats::openBtf(path("patch.btf"));
  const auto runBoth = [&](const formats::Json& material, const std::string& options,
                           const std::string& lights = "4") {
    std::ofstream(folder_ / "material.json") << material;
    return tests::shell(std::string(BAKELIGHT_BIN_DIR) + "/rtt --material '" + path("material.json") +
                        "' --progress none --resolution 8 --elements 8 --views 2 --btf-lights " + lights +
                        " --btfs '" + tables + "' --stats '" + path("stats.json") + "' " + options);
  };
  const tests::ShellOutcome both = runBoth({{"material", dents_}, {"materials", {{"wall", stucco}}}}, "");
  ASSERT_EQ(both.status, 0) << both.output;
  const std::vector<formats::BtfTable> written = formats::readBtfTables(tables);
  ASSERT_EQ(written.size(), 2U);
  EXPECT_EQ(written[0].material, "");
  ASSERT_EQ(written[1].material, "wall");
  EXPECT_EQ(written[1].lights, 4);
  EXPECT_EQ(formats::readJson(folder_ / "stats.json").at("stats").at("btfs").size(), 2U);
  const std::size_t texels = 64, cells = 16;
  std::vector<int> lights(cells);
  std::iota(lights.begin(), lights.end(), 0);
  for (int view = 0; view < 4; ++view) {
    const std::vector<float> values = written[1].valuesOf(static_cast<std::size_t>(view));
    std::vector<float> expected(3 * cells * texels);
    alone->view(view)->decode(lights, {0, texels}, expected);
    for (std::size_t t = 0; t < texels; ++t)
      for (std::size_t i = 0; i < 3 * cells; ++i)
        ASSERT_EQ(values[t * 3 * cells + i], expected[i * texels + t]);
  }

  const formats::Json measured = {{"material", dents_},
                                  {"materials", {{"wall", {{"patch", {{"btf", {{"file", "w.btf"}}}}}}}}}};
  std::ofstream(folder_ / "w.btf") << "!DFMF08FCR";
  const tests::ShellOutcome missing = runBoth(measured, "");
  EXPECT_EQ(missing.status, 2);
  EXPECT_NE(missing.output.find("measured_btfs"), std::string::npos) << missing.output;
  std::filesystem::copy(tables, path("measured.safetensors"));
  const tests::ShellOutcome taken =
      runBoth(measured, "--measured-btfs '" + path("measured.safetensors") + "'");
  ASSERT_EQ(taken.status, 0) << taken.output;
  const std::vector<formats::BtfTable> again = formats::readBtfTables(tables);
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[1].valuesOf(3), written[1].valuesOf(3));
  const tests::ShellOutcome other =
      runBoth(measured, "--measured-btfs '" + path("measured.safetensors") + "'", "2");
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.output.find("btf_lights"), std::string::npos) << other.output;
}

TEST_F(RttToolTest, SaysWhyABtfCannotBeMade) {
  const tests::ShellOutcome two = run({{"material", dents_}, {"materials", {{"lid", dents_}}}}, "");
  EXPECT_EQ(two.status, 2);
  EXPECT_NE(two.output.find("2 materials have a patch"), std::string::npos) << two.output;
  const tests::ShellOutcome large = run(dents_, "", "--resolution 128 --views 32 --order 1");
  EXPECT_EQ(large.status, 1);
  EXPECT_NE(large.output.find("btf_lights"), std::string::npos) << large.output;
  const tests::ShellOutcome fine = run(dents_, "--btf-lights 32", "--elements 400");
  EXPECT_EQ(fine.status, 1);
  EXPECT_NE(fine.output.find("elements"), std::string::npos) << fine.output;
}

}  // namespace
}  // namespace bakelight::rtt
