#include "formats/tool_description.h"

#include <gtest/gtest.h>

namespace bakelight::formats {
namespace {

ToolDescription sample() {
  ToolDescription tool;
  tool.tool = "sample";
  tool.summary = "A tool.";
  tool.execution_path = "embree avx2";
  tool.inputs = {{"mesh", "mesh", true, "the mesh"}, {"material", "material", false, "", {"albedo"}}};
  tool.outputs = {{"table", "tensors", false, "the table"}};
  ParameterDescription order;
  order.name = "order";
  order.type = ParameterType::kInteger;
  order.default_value = 5;
  order.minimum = 1;
  order.maximum = 10;
  order.unit = "bands";
  order.changes_object = true;
  ParameterDescription bias;
  bias.name = "bias";
  bias.type = ParameterType::kReal;
  bias.default_value = 1e-4;
  bias.minimum = 0;
  ParameterDescription mode;
  mode.name = "mode";
  mode.type = ParameterType::kText;
  mode.default_value = "shadowed";
  mode.choices = {"shadowed", "unshadowed"};
  ParameterDescription albedo;
  albedo.name = "albedo";
  albedo.type = ParameterType::kRealList;
  albedo.length = 3;
  albedo.default_value = {1, 1, 1};
  albedo.minimum = 0;
  albedo.maximum = 1;
  ParameterDescription draco;
  draco.name = "draco";
  draco.default_value = false;
  tool.parameters = {order, bias, mode, albedo, draco};
  tool.retired = {{"lobe", "a material"}};
  return tool;
}

struct Refusal {
  std::string pointer, problem, expected, remedy;
};

Refusal refusalOf(const Json& values) {
  try {
    checkParameters(sample(), values, {"asset.json", "", "/stages/transfer"});
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    EXPECT_EQ(error.place().file, "asset.json");
    return {error.place().pointer, error.problem(), error.expected(), error.remedy()};
  }
  return {"no error", "", "", ""};
}

TEST(ToolDescription, SurvivesItsJson) {
  const Json json = toJson(sample());
  EXPECT_EQ(toJson(toolDescriptionFromJson(json, "sample")), json);
  EXPECT_EQ(toolDescriptionFromJson(json, "sample").execution_path, "embree avx2");
  const ToolDescription read = toolDescriptionFromJson(json, "sample");
  EXPECT_EQ(read.inputs.at(1).parts, std::vector<std::string>{"albedo"});
  EXPECT_TRUE(read.findParameter("order")->changes_object);
  EXPECT_EQ(read.findRetired("lobe")->instead, "a material");
}

TEST(ToolDescription, RefusesWhatIsNone) {
  EXPECT_THROW(toolDescriptionFromJson(Json::parse("{}"), "sample"), Error);
  EXPECT_THROW(toolDescriptionFromJson(Json::parse("[]"), "sample"), Error);
  Json json = toJson(sample());
  json["parameters"][0]["type"] = "matrix";
  EXPECT_THROW(toolDescriptionFromJson(json, "sample"), Error);
}

TEST(CheckParameters, GivesCanonicalValues) {
  const Json checked = checkParameters(
      sample(),
      Json::parse(R"({"order": 7, "bias": 1, "mode": "unshadowed", "albedo": [0, 1, 0.5], "draco": true})"),
      {});
  EXPECT_EQ(checked.dump(),
            R"({"albedo":[0.0,1.0,0.5],"bias":1.0,"draco":true,"mode":"unshadowed","order":7})");
}

TEST(CheckParameters, NamesPointerRangeAndNearestName) {
  EXPECT_EQ(refusalOf(Json::parse(R"({"order": 99})")).pointer, "/stages/transfer/order");
  EXPECT_EQ(refusalOf(Json::parse(R"({"order": 99})")).expected, "an integer from 1 to 10");
  EXPECT_EQ(refusalOf(Json::parse(R"({"order": 0})")).pointer, "/stages/transfer/order");
  EXPECT_EQ(refusalOf(Json::parse(R"({"order": 2.5})")).pointer, "/stages/transfer/order");
  EXPECT_EQ(refusalOf(Json::parse(R"({"order": "5"})")).pointer, "/stages/transfer/order");
  EXPECT_EQ(refusalOf(Json::parse(R"({"order": 18446744073709551615})")).pointer, "/stages/transfer/order");
  EXPECT_EQ(refusalOf(Json::parse(R"({"bias": -1})")).expected, "a number of 0 or more");
  EXPECT_EQ(refusalOf(Json::parse(R"({"mode": "unshadwed"})")).remedy, "\"unshadowed\"");
  EXPECT_EQ(refusalOf(Json::parse(R"({"albedo": [0, 1]})")).expected, "a list of 3 numbers from 0 to 1");
  EXPECT_EQ(refusalOf(Json::parse(R"({"albedo": [0, 1, 2]})")).pointer, "/stages/transfer/albedo");
  EXPECT_EQ(refusalOf(Json::parse(R"({"draco": 1})")).expected, "true or false");
  EXPECT_EQ(refusalOf(Json::parse(R"({"ordr": 5})")).remedy, "\"order\"");
  EXPECT_EQ(refusalOf(Json::parse(R"({"lobe": "ggx"})")).remedy, "a material");
  EXPECT_EQ(refusalOf(Json::parse(R"([1])")).pointer, "/stages/transfer");
}

}  // namespace
}  // namespace bakelight::formats
