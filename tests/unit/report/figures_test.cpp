// Fronts, times, axes, labels and numbers: what the page is made of.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/report/axis.h"
#include "tools/report/pareto.h"
#include "tools/report/plot.h"
#include "tools/report/recently_used.h"
#include "tools/report/text.h"
#include "tools/report/thumbnails.h"
#include "tools/report/timing.h"
#include "tools/report/varied.h"

namespace bakelight::report {
namespace {

using Indices = std::vector<std::size_t>;

TEST(ParetoFront, KeepsWhatNothingBeats) {
  const std::vector<CostAndError> points = {{4, 1}, {1, 4}, {2, 2},   {3, 2},
                                            {2, 3}, {5, 1}, {0.5, 9}, {4, 0.5}};
  EXPECT_EQ(paretoFront(points), (Indices{6, 1, 2, 7}));
}

TEST(ParetoFront, KeepsEqualPointsAndDropsTiesThatAreWorse) {
  EXPECT_EQ(paretoFront(std::vector<CostAndError>{{1, 1}, {1, 1}, {1, 2}, {2, 1}}), (Indices{0, 1}));
  EXPECT_EQ(paretoFront(std::vector<CostAndError>{{NAN, 1}, {1, INFINITY}, {2, 2}}), (Indices{2}));
  EXPECT_TRUE(paretoFront({}).empty());
}

// Against the definition, on many points with ties.
TEST(ParetoFront, IsWhatItsDefinitionSays) {
  std::vector<CostAndError> points;
  for (int i = 0; i < 300; ++i)
    points.push_back({static_cast<double>((i * 71) % 37), 40.0 - (i * 71) % 37 + (i * 53) % 11});
  std::set<std::size_t> expected;
  for (std::size_t i = 0; i < points.size(); ++i) {
    bool beaten = false;
    for (const CostAndError& other : points)
      beaten |= other.cost <= points[i].cost && other.error <= points[i].error &&
                (other.cost < points[i].cost || other.error < points[i].error);
    if (!beaten) expected.insert(i);
  }
  const Indices front = paretoFront(points);
  EXPECT_EQ(std::set<std::size_t>(front.begin(), front.end()), expected);
  EXPECT_GT(front.size(), 1u);
}

TEST(Timing, SpreadsAreQuartiles) {
  const Spread spread = spreadOf({5, 1, 4, 2, 3});
  EXPECT_EQ(spread.median, 3);
  EXPECT_EQ(spread.low, 2);
  EXPECT_EQ(spread.high, 4);
  EXPECT_EQ(spreadOf({1, 2}).median, 1.5);
  EXPECT_THROW(spreadOf({}), std::invalid_argument);
}

TEST(Timing, GoesRoundAllCandidatesInTurnAndForgetsTheWarmUp) {
  std::string order;
  const auto candidate = [&](char name) {
    return [&order, name](int round) {
      order += name;
      return std::vector<double>{round < 0 ? 1e9 : round, 7};
    };
  };
  const auto spreads = measureInTurn({candidate('a'), candidate('b')}, 3);
  EXPECT_EQ(order, "ababababab");
  ASSERT_EQ(spreads.size(), 2u);
  EXPECT_EQ(spreads[0][0].median, 1) << "rounds 0, 1, 2";
  EXPECT_EQ(spreads[1][1].median, 7);
}

TEST(Axis, IsLogarithmicWithRoundTicks) {
  const Axis axis(std::vector<double>{0.02, 0.5, 3, 0, -1}, 6);
  EXPECT_GT(axis.position(0.02), 0);
  EXPECT_LT(axis.position(3), 1);
  EXPECT_NEAR(axis.position(0.5) - axis.position(0.05), axis.position(1) - axis.position(0.1), 1e-12);
  EXPECT_EQ(axis.position(0), 0) << "zero stands at the low end";
  for (const std::vector<double>& values :
       {std::vector<double>{0.02, 3}, {1e-6, 1e6}, {5}, {1.00, 1.01}, {}, {0}, {7, 30}}) {
    const Axis of_values(values, 6);
    EXPECT_GE(of_values.ticks().size(), 2u) << testing::PrintToString(values);
    EXPECT_LE(of_values.ticks().size(), 6u) << testing::PrintToString(values);
    for (const double tick : of_values.ticks()) {
      EXPECT_GT(tick, 0);
      EXPECT_GE(of_values.position(tick), 0);
      EXPECT_LE(tickText(tick).size(), 8u) << tick;
    }
  }
}

TEST(Text, NumbersAreShortAndEscapedTextIsHarmless) {
  EXPECT_EQ(numberText(0.03124), "0.0312");
  EXPECT_EQ(numberText(12345.6), "12346");
  EXPECT_EQ(numberText(9.996), "10.0");
  EXPECT_EQ(numberText(0), "0");
  EXPECT_EQ(numberText(1.5e-7), "1.50e-07");
  EXPECT_EQ(numberText(NAN), "–");
  EXPECT_EQ(tickText(7), "7");
  EXPECT_EQ(tickText(0.5), "0.5");
  EXPECT_EQ(tickText(100), "100");
  EXPECT_EQ(percentText(0.0312), "3.12 %");
  EXPECT_EQ(bytesText(999), "999 B");
  EXPECT_EQ(bytesText(1234567), "1.23 MB");
  EXPECT_EQ(bytesText(999999), "1.00 MB");
  EXPECT_EQ(bytesTickText(2e6), "2 MB");
  EXPECT_EQ(coordinate(1.5), "1.5");
  EXPECT_EQ(coordinate(-0.0001), "0");
  EXPECT_EQ(coordinate(1000), "1000");
  EXPECT_EQ(escaped("<a href=\"x\">'&"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;");
}

Plan planOf(const std::vector<formats::Json>& parameters) {
  Plan plan;
  for (const formats::Json& variant : parameters) {
    plan.variants.emplace_back();
    plan.variants.back().name = variant.dump();
    plan.variants.back().parameters = variant;
  }
  return plan;
}

TEST(Varied, TextParametersAreShownAndTheOthersLabel) {
  const Plan plan = planOf({{{"t.order", 2}, {"p.storage", "full"}, {"p.same", 1}, {"t.albedo", {1, 1, 1}}},
                            {{"t.order", 3}, {"p.storage", "full"}, {"p.same", 1}, {"t.albedo", {0, 1, 1}}},
                            {{"t.order", 3}, {"p.storage", "cpca"}, {"p.same", 1}, {"t.albedo", {0, 1, 1}}},
                            {{"t.order", 4}, {"p.same", 1}, {"t.albedo", {0, 1, 1}}}});
  const Varied varied = variedParameters(plan, 7);
  ASSERT_EQ(varied.parameters.size(), 3u);
  ASSERT_TRUE(varied.hasShown());
  EXPECT_EQ(varied.parameters[varied.shown].name, "p.storage");
  EXPECT_EQ(varied.parameters[varied.shown].values, (std::vector<std::string>{"full", "cpca", "–"}));
  EXPECT_EQ(shortLabel(plan, varied, 2), "[0,1,1] · 3");
  EXPECT_EQ(groupText(plan, varied, {0, 1}), "p.storage=full");
  EXPECT_EQ(groupText(plan, varied, {1, 2}), "t.albedo=[0,1,1], t.order=3");
  EXPECT_EQ(groupText(plan, varied, {0, 1, 2, 3}), "all");
  EXPECT_EQ(groupText(plan, varied, {0, 3}), plan.variants[0].name + ", " + plan.variants[3].name);
}

// A setting that comes with another one, as shadowed transport with visibility, says nothing new.
TEST(Varied, LabelsLeaveOutWhatGoesWithTheShownParameter) {
  const Plan plan = planOf({{{"order", 2}, {"storage", "a"}, {"transport", "x"}},
                            {{"order", 3}, {"storage", "b"}, {"transport", "y"}},
                            {{"order", 2}, {"storage", "b"}, {"transport", "y"}},
                            {{"order", 3}, {"storage", "c"}, {"transport", "x"}}});
  const Varied varied = variedParameters(plan, 7);
  EXPECT_EQ(varied.parameters[varied.shown].name, "storage");
  EXPECT_EQ(shortLabel(plan, varied, 1), "3");
}

TEST(Varied, NumbersAreShownWhereThereIsNoText) {
  const Varied numbers =
      variedParameters(planOf({{{"a", 1}, {"b", 1}}, {{"a", 1}, {"b", 2}}, {{"a", 2}, {"b", 3}}}), 7);
  EXPECT_EQ(numbers.parameters[numbers.shown].name, "b");
  const Varied few =
      variedParameters(planOf({{{"a", 1}, {"b", 1}}, {{"a", 1}, {"b", 2}}, {{"a", 2}, {"b", 3}}}), 2);
  EXPECT_EQ(few.parameters[few.shown].name, "a") << "more values than there are colours";
  const Plan one = planOf({formats::Json::object()});
  EXPECT_FALSE(variedParameters(one, 7).hasShown());
  EXPECT_EQ(shortLabel(one, variedParameters(one, 7), 0), "{}");
}

TEST(Plot, ShowsEveryPointAndLabelsTheFront) {
  Plot plot{"Run <time>", "ms", "error", tickText, tickText, {}, {0, 2}};
  plot.points = {{"a", "A", "first", 1, 0.3, 0.9, 1.2, 0},
                 {"b", "B", "", 2, 0.5, 2, 2, 1},
                 {"c", "C&C", "", 4, 0, 4, 4, 6}};
  const std::string svg = plotSvg(plot);
  for (const char* expected :
       {"data-variant=\"a\"", "data-variant=\"b\"", "data-variant=\"c\"", ">A</text>", ">C&amp;C</text>",
        "Run &lt;time&gt;", "class=\"whisker\"", "class=\"front\"", "<title>first</title>"})
    EXPECT_NE(svg.find(expected), std::string::npos) << expected;
  EXPECT_EQ(svg.find(">B</text>"), std::string::npos) << "a beaten point has no label";
  std::set<std::string> shapes;
  for (std::size_t marker = 0; marker < kMarkers; ++marker) shapes.insert(markerSvg(marker, 0, 0, true));
  EXPECT_EQ(shapes.size(), kMarkers);
}

TEST(DifferenceColors, DarkenSteadily) {
  double before = 2;
  for (double position = 0; position <= 1; position += 1.0 / 64) {
    const auto color = differenceColor(position);
    const double lightness = 0.2126 * std::pow(color[0], 2.2) + 0.7152 * std::pow(color[1], 2.2) +
                             0.0722 * std::pow(color[2], 2.2);
    EXPECT_LT(lightness, before) << position;
    before = lightness;
  }
  EXPECT_EQ(differenceColor(2), differenceColor(1));
}

TEST(RecentlyUsed, MakesOnceAndForgetsTheOldest) {
  RecentlyUsed<int> recent(2);
  int made = 0;
  const auto make = [&] { return ++made; };
  EXPECT_EQ(*recent.get("a", make), 1);
  EXPECT_EQ(*recent.get("b", make), 2);
  EXPECT_EQ(*recent.get("a", make), 1);
  EXPECT_EQ(*recent.get("c", make), 3);
  EXPECT_EQ(*recent.get("a", make), 1) << "used later than b";
  EXPECT_EQ(*recent.get("b", make), 4);
}

}  // namespace
}  // namespace bakelight::report
