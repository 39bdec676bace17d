#include "pipeline/budget.h"

#include <nlohmann/json.hpp>

#include "pipeline/problems.h"

namespace bakelight::pipeline {
namespace {

using formats::Json;
using testing::HasSubstr;

const ErrorPlace kPlace{"asset.json", "", "/budget"};

Json variant(const std::string& name, double error, double frame_ms, double bytes) {
  return {{"name", name},
          {"parameters", {{"transfer.order", name.size()}}},
          {"rel_rmse", error},
          {"frame_ms", frame_ms},
          {"bytes", bytes}};
}

// A front of four, one point that another beats in everything, and one that is small but slow.
Json report() {
  return {
      {"variants",
       {variant("coarse", 0.2, 1, 100), variant("fair", 0.05, 2, 300), variant("good", 0.02, 4, 900),
        variant("best", 0.01, 8, 1600), variant("beaten", 0.06, 3, 400), variant("small", 0.04, 9, 200)}}};
}

std::string chosen(const Json& budget) {
  return chooseVariant(parseBudget(budget, kPlace), report(), kPlace).at("chosen");
}

TEST(Budget, AnErrorIsKeptAtTheLeastTime) {
  EXPECT_EQ(chosen({{"error", 0.05}}), "fair") << "the limit itself is within";
  EXPECT_EQ(chosen({{"error", 0.049}}), "good") << "small errs little enough, too, but is slower";
  EXPECT_EQ(chosen({{"error", 0.5}}), "coarse");
}

TEST(Budget, ATimeOrASizeIsUsedForTheLeastError) {
  EXPECT_EQ(chosen({{"frame_ms", 4.5}}), "good");
  EXPECT_EQ(chosen({{"bytes", 350}}), "small");
  EXPECT_EQ(chosen({{"bytes", 350}, {"frame_ms", 5}}), "fair");
}

TEST(Budget, ErrorAndSizeTogetherAreKeptByTheSmallest) {
  EXPECT_EQ(chosen({{"error", 0.06}, {"bytes", 1000}}), "small");
}

TEST(Budget, TheChoiceSaysWhyAndWhatTheNeighborsCost) {
  const Json choice = chooseVariant(parseBudget({{"error", 0.05}}, kPlace), report(), kPlace);
  EXPECT_EQ(choice.at("rel_rmse"), 0.05);
  EXPECT_EQ(choice.at("parameters"), Json({{"transfer.order", 4}}));
  EXPECT_EQ(choice.at("next_better").at("name"), "good") << "the fastest that errs less";
  EXPECT_EQ(choice.at("next_cheaper").at("name"), "coarse");
  EXPECT_THAT(choice.at("why").get<std::string>(), HasSubstr("the fastest of 4 variants"));
  EXPECT_TRUE(
      chooseVariant(parseBudget({{"error", 0.01}}, kPlace), report(), kPlace).at("next_better").is_null());
}

TEST(Budget, NoVariantWithinItIsAnErrorThatNamesTheNearest) {
  try {
    chosen({{"error", 0.001}, {"frame_ms", 8}});
    FAIL() << "kept";
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().pointer, "/budget");
    EXPECT_THAT(error.expected(), HasSubstr("the nearest is best"));
  }
}

TEST(Budget, WhatLimitsNothingOrIsNoNumberIsRefused) {
  EXPECT_THROW(parseBudget(Json::object(), kPlace), Error);
  EXPECT_THROW(parseBudget({{"error", 0}}, kPlace), Error);
  EXPECT_THROW(parseBudget({{"error", "small"}}, kPlace), Error);
  EXPECT_THROW(parseBudget({{"time", 1}}, kPlace), ProblemsFound);
  EXPECT_THROW(parseBudget(0.03, kPlace), Error);
}

}  // namespace
}  // namespace bakelight::pipeline
