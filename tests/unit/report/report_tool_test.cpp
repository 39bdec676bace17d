// The executable, on files.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/json.h"
#include "tests/unit/report/made_report.h"

namespace bakelight::tests {
namespace {

namespace fs = std::filesystem;
using formats::Json;

class ReportTool : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() /
        ("bakelight-report-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  int run(const fs::path& plan) const {
    const std::string command = "'" BAKELIGHT_BIN_DIR "/report' '" + plan.string() + "' --report '" +
                                (folder_ / "report.json").string() + "' --page '" +
                                (folder_ / "report.html").string() + "' --rounds 2 2> '" +
                                (folder_ / "messages").string() + "'";
    return std::system(command.c_str());
  }

  fs::path folder_;
};

TEST_F(ReportTool, MakesReportAndPageFromFiles) {
  MadeReport made(madeGlossyPack(5, 12));
  made.addVariant("order=2", {{"transfer.order", 2}}, madeGlossyPack(2, 12));
  made.addVariant("order=4", {{"transfer.order", 4}}, madeGlossyPack(4, 12));
  ASSERT_EQ(run(made.write(folder_)), 0);
  const Json report = formats::readJson(folder_ / "report.json");
  ASSERT_EQ(report["variants"].size(), 2u);
  EXPECT_GT(report["variants"][0]["rel_rmse"].get<double>(), report["variants"][1]["rel_rmse"].get<double>());
  EXPECT_EQ(report["variants"][0]["bytes"], fs::file_size(folder_ / "pack0.glb"));
  EXPECT_GT(fs::file_size(folder_ / "report.html"), 10000u);
}

TEST_F(ReportTool, RefusesAPlanWithAMistake) {
  formats::writeJson(folder_ / "plan.json",
                     {{"asset", "x"}, {"views", Json::array()}, {"variant", Json::array()}});
  EXPECT_EQ(WEXITSTATUS(run(folder_ / "plan.json")), 2);
  EXPECT_FALSE(fs::exists(folder_ / "report.json"));
}

}  // namespace
}  // namespace bakelight::tests
