#include "tools/stage/progress.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <nlohmann/json.hpp>
#include <sstream>

namespace bakelight::stage {
namespace {

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Progress, JsonLinesEndAtTheTotal) {
  testing::internal::CaptureStderr();
  {
    Progress progress(ProgressStyle::kJson, "transfer", 1000, "vertices");
    tbb::parallel_for(0, 1000, [&](int) { progress.advance(); });
  }
  const auto lines = linesOf(testing::internal::GetCapturedStderr());
  ASSERT_FALSE(lines.empty());
  for (const auto& line : lines) {
    const auto json = nlohmann::json::parse(line)["progress"];
    EXPECT_EQ(json["label"], "transfer");
    EXPECT_EQ(json["total"], 1000);
    EXPECT_LE(json["done"], 1000);
  }
  EXPECT_EQ(nlohmann::json::parse(lines.back())["progress"]["done"], 1000);
}

TEST(Progress, PlainLinesAreFew) {
  testing::internal::CaptureStderr();
  {
    Progress progress(ProgressStyle::kLines, "transfer", 100000, "vertices");
    for (int i = 0; i < 100000; ++i) progress.advance();
  }
  const auto lines = linesOf(testing::internal::GetCapturedStderr());
  EXPECT_GE(lines.size(), 1u);
  EXPECT_LE(lines.size(), 10u);
  EXPECT_THAT(lines.back(), testing::StartsWith("transfer: 100%"));
}

TEST(Progress, SilentStyleAndUnknownTotal) {
  testing::internal::CaptureStderr();
  {
    Progress silent(ProgressStyle::kNone, "a", 10, "b");
    silent.advance(10);
    Progress unknown(ProgressStyle::kLines, "a", 0, "b");
    unknown.advance(5);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace bakelight::stage
