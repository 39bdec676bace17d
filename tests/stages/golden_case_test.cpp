#include "tests/stages/golden_case.h"

#include <cmath>
#include <fstream>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/mesh_ply.h"
#include "tests/stages/scenes.h"

namespace bakelight::stages {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

// A case whose tool is a shell script: it copies in.ply to out.ply, and does what a test adds.
class GoldenCaseTest : public ::testing::Test {
 protected:
  GoldenCaseTest() {
    fs::remove_all(root_);
    fs::create_directories(work());
    writeTool("");
    writeCase(R"({"about": "a copy", "inputs": [{"file": "in.ply", "scene": "sphere", "subdivisions": 1}],
                  "commands": [["copy"]], "outputs": [{"file": "out.ply", "kind": "mesh"}]})");
    formats::writePly(caseFolder() / "golden/out.ply", sphere(1));
  }
  ~GoldenCaseTest() override { fs::remove_all(root_); }

  fs::path caseFolder() const { return root_ / "case"; }
  fs::path work() const { return root_ / "work"; }
  void writeCase(const std::string& text) const {
    formats::writeFileAtomically(caseFolder() / "case.json", text);
  }
  void writeTool(const std::string& more) const {
    formats::writeFileAtomically(root_ / "bin/copy", "#!/bin/sh\ncp in.ply out.ply\n" + more + "\n");
    fs::permissions(root_ / "bin/copy", fs::perms::owner_all);
  }
  std::vector<OutputComparison> run() const {
    const GoldenCase golden_case = readCase(caseFolder());
    runCase(golden_case, root_ / "bin", work(), 1);
    return compareWithGolden(golden_case, work());
  }
  std::string errorOf(const std::function<void()>& body) const {
    try {
      body();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

  const fs::path root_ =
      fs::temp_directory_path() /
      (std::string("bakelight_golden_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(GoldenCaseTest, EqualOutputsPass) {
  const auto comparisons = run();
  ASSERT_EQ(comparisons.size(), 1U);
  EXPECT_TRUE(comparisons[0].comparison.passes());
  EXPECT_THAT(asText(comparisons[0]), HasSubstr("out.ply: within its limits, 50 values compared"));
}

TEST_F(GoldenCaseTest, AnotherOutputFails) {
  formats::writePly(caseFolder() / "golden/out.ply", bumpySphere(1));
  const auto comparisons = run();
  ASSERT_EQ(comparisons.size(), 1U);
  EXPECT_FALSE(comparisons[0].comparison.passes());
  EXPECT_THAT(asText(comparisons[0]), HasSubstr("DIFFERS"));
}

TEST_F(GoldenCaseTest, AnExtraOutputFails) {
  writeTool("touch more.txt");
  EXPECT_THAT(errorOf([&] { run(); }), HasSubstr("more.txt: is there, but case.json does not name it"));
}

TEST_F(GoldenCaseTest, AMissingOutputFails) {
  writeTool("rm out.ply");
  EXPECT_THAT(errorOf([&] { run(); }), HasSubstr("out.ply: is missing"));
}

TEST_F(GoldenCaseTest, AMissingGoldenFileFails) {
  fs::remove(caseFolder() / "golden/out.ply");
  EXPECT_THAT(errorOf([&] { run(); }), HasSubstr("make golden-update CASE=case"));
}

TEST_F(GoldenCaseTest, AnExtraGoldenFileFails) {
  formats::writePly(caseFolder() / "golden/old.ply", sphere(1));
  EXPECT_THAT(errorOf([&] { run(); }), HasSubstr("old.ply"));
}

TEST_F(GoldenCaseTest, AFailingCommandFails) {
  writeTool("exit 2");
  EXPECT_THAT(errorOf([&] { run(); }), HasSubstr("copy ended with status 2"));
}

TEST_F(GoldenCaseTest, WhatTheMachineLacksIsSaidSo) {
  writeTool("exit 3");
  try {
    run();
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kNotAvailable);
  }
}

TEST_F(GoldenCaseTest, ThreadsThatChangeAnOutputAreFound) {
  writeTool("echo $4 > scratch");  // copy --progress none --threads N
  writeCase(R"({"about": "a copy", "inputs": [{"file": "in.ply", "scene": "sphere"}],
                "commands": [["copy"]], "scratch": ["scratch"], "outputs": [{"file": "out.ply", "kind": "mesh"}]})");
  const GoldenCase golden_case = readCase(caseFolder());
  fs::create_directories(root_ / "other");
  runCase(golden_case, root_ / "bin", work(), 1);
  runCase(golden_case, root_ / "bin", root_ / "other", 4);
  EXPECT_THAT(differingFiles(golden_case, work(), work()), IsEmpty());
  EXPECT_THAT(differingFiles(golden_case, work(), root_ / "other"), ElementsAre("scratch"));
}

TEST_F(GoldenCaseTest, ACaseWithoutOutputsIsRefused) {
  writeCase(
      R"({"about": "x", "inputs": [{"file": "in.ply", "scene": "sphere"}], "commands": [["copy"]], "outputs": []})");
  EXPECT_THAT(errorOf([&] { readCase(caseFolder()); }), HasSubstr("/outputs"));
}

TEST_F(GoldenCaseTest, LimitsNeedAReason) {
  writeCase(R"({"about": "x", "inputs": [{"file": "in.ply", "scene": "sphere"}], "commands": [["copy"]],
                "outputs": [{"file": "out.ply", "kind": "mesh", "limits": {"distance": 1}}]})");
  EXPECT_THAT(errorOf([&] { readCase(caseFolder()); }),
              HasSubstr("/outputs/0: the key \"reason\" is missing"));
}

TEST_F(GoldenCaseTest, AnUnknownLimitIsRefused) {
  writeCase(R"({"about": "x", "inputs": [{"file": "in.ply", "scene": "sphere"}], "commands": [["copy"]],
                "outputs": [{"file": "out.ply", "kind": "mesh", "limits": {"distanse": 1}, "reason": "x"}]})");
  EXPECT_THAT(errorOf([&] { readCase(caseFolder()); }), HasSubstr("distanse"));
}

TEST(Scenes, SpheresHaveUnitRadiusAndEulersCount) {
  for (int subdivisions = 0; subdivisions < 4; ++subdivisions) {
    const formats::TriangleMesh mesh = sphere(subdivisions);
    EXPECT_EQ(mesh.vertexCount(), (4U << (2 * subdivisions)) + 2);
    EXPECT_EQ(mesh.triangleCount(), 8U << (2 * subdivisions));
    for (const auto& p : mesh.positions) EXPECT_NEAR(std::hypot(p[0], p[1], p[2]), 1, 1e-6);
  }
}

TEST(Scenes, BumpsStayWithinAQuarterOrSo) {
  float low = 2, high = 0;
  for (const auto& p : bumpySphere(4).positions) {
    const float radius = std::hypot(p[0], p[1], p[2]);
    low = std::min(low, radius), high = std::max(high, radius);
  }
  EXPECT_GT(low, 0.7f);
  EXPECT_LT(low, 0.85f);
  EXPECT_GT(high, 1.15f);
  EXPECT_LT(high, 1.3f);
}

TEST(Scenes, TheBowlFacesItsCenter) {
  const formats::TriangleMesh mesh = bowl(2);
  EXPECT_EQ(mesh.triangleCount(), sphere(2).triangleCount() / 2);
  for (std::size_t i = 0; i < mesh.vertexCount(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(mesh.normals[i][axis], -mesh.positions[i][axis]);
}

}  // namespace
}  // namespace bakelight::stages
