#include "formats/json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/hash.h"
#include "formats/json_reader.h"
#include "formats/stage_record.h"
#include "formats/words.h"
#include "tests/support/temporary_folder.h"

namespace bakelight::formats {
namespace {

std::string paragraphOf(const std::string& text) {
  try {
    parseJson(text, "asset.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.status(), ExitStatus::kBadInput);
    return error.paragraph();
  }
  return "no error";
}

TEST(Json, SyntaxErrorNamesLineAndColumn) {
  EXPECT_THAT(paragraphOf("{\n  \"order\": 5,\n  \"mesh\" 3\n}"),
              testing::HasSubstr("asset.json, line 3, column 10"));
  EXPECT_THAT(paragraphOf("{\"a\": 1"), testing::HasSubstr("line 1"));
  EXPECT_THAT(paragraphOf(""), testing::HasSubstr("line 1, column 1"));
}

TEST(Json, KeyThatStandsTwiceIsAnError) {
  EXPECT_THAT(paragraphOf(R"({"a": {"order": 1}, "b": {"order": 2, "order": 3}})"),
              testing::HasSubstr("\"order\""));
  EXPECT_EQ(parseJson(R"({"a": {"order": 1}, "b": {"order": 2}})", "f").size(), 2u);
}

TEST(Json, CommentsAreAllowed) {
  EXPECT_EQ(parseJson("// why\n{\"a\": /* because */ 1}", "f")["a"], 1);
}

TEST(Json, PointersAreEscaped) {
  EXPECT_EQ(childPointer("/stages", "a/b~c"), "/stages/a~1b~0c");
}

TEST(Json, NearestNameFindsMisspellings) {
  const std::vector<std::string> names = {"order", "directions", "visibility", "bias"};
  EXPECT_EQ(nearestName("ordr", names), "order");
  EXPECT_EQ(nearestName("direction", names), "directions");
  EXPECT_EQ(nearestName("visiblity", names), "visibility");
  EXPECT_EQ(nearestName("triangles", names), "");
}

enum class Shape { kQuad, kSphere };
constexpr Word<Shape> kShapes[] = {{"quad", Shape::kQuad}, {"sphere", Shape::kSphere}};

TEST(Words, StandForValues) {
  EXPECT_THAT(textsOf(kShapes), testing::ElementsAre("quad", "sphere"));
  EXPECT_STREQ(wordFor(kShapes, Shape::kSphere), "sphere");
  ASSERT_NE(valueFor(kShapes, "sphere"), nullptr);
  EXPECT_EQ(*valueFor(kShapes, "sphere"), Shape::kSphere);
  EXPECT_EQ(valueFor(kShapes, "cone"), nullptr);
}

class JsonReaderTest : public testing::Test {
 protected:
  // The paragraph of what reading throws.
  template <class Read>
  std::string problem(const char* text, const Read& read) const {
    const Json json = parseJson(text, "rig.json");
    try {
      read(JsonReader(json, "rig.json", "/lights/0"));
    } catch (const Error& error) {
      EXPECT_EQ(error.status(), ExitStatus::kBadInput);
      return error.paragraph();
    }
    return "no error";
  }
};

TEST_F(JsonReaderTest, ReadsMembersAndKeepsDefaults) {
  const Json json = parseJson(
      R"({"name": "a", "on": true, "radius": 2, "count": 3, "at": [1, 2, 3], "shape": "sphere",
          "tags": ["x", "y"], "inner": {"depth": 12.0}})",
      "rig.json");
  const JsonReader reader(json, "rig.json");
  std::string name;
  bool on = false;
  double radius = 1, width = 5;
  int count = 0;
  Float3 at = {0, 0, 0};
  Shape shape = Shape::kQuad;
  reader.read("name", name);
  reader.read("on", on);
  reader.read("radius", radius, {.minimum = 0});
  reader.read("width", width, {.minimum = 0});
  reader.read("count", count, {.minimum = 1, .maximum = 9});
  reader.read("at", at, {});
  reader.read("shape", shape, kShapes);
  EXPECT_EQ(name, "a");
  EXPECT_TRUE(on);
  EXPECT_EQ(radius, 2);
  EXPECT_EQ(width, 5);
  EXPECT_EQ(count, 3);
  EXPECT_EQ(at, (Float3{1, 2, 3}));
  EXPECT_EQ(shape, Shape::kSphere);
  EXPECT_THAT(reader.texts("tags"), testing::ElementsAre("x", "y"));
  EXPECT_EQ(reader.object("inner").whole("depth", 0), 12U);
  EXPECT_EQ(reader.object("outer").text("label", "none"), "none");
  EXPECT_TRUE(reader.items("others").empty());
  EXPECT_NO_THROW(reader.refuseOthers());
}

TEST_F(JsonReaderTest, EveryErrorHasFilePointerAndExpectation) {
  using testing::AllOf;
  using testing::HasSubstr;
  struct Case {
    const char* text;
    std::function<void(const JsonReader&)> read;
    const char *place, *expected;
  };
  const Case cases[] = {
      {"[]", [](const auto& r) { r.has("a"); }, "rig.json, at /lights/0", "a JSON object"},
      {"{}", [](const auto& r) { r.text("a"); }, "at /lights/0: the key \"a\" is missing", "a text"},
      {R"({"a": 3})", [](const auto& r) { r.text("a"); }, "at /lights/0/a", "a text"},
      {R"({"a": "x"})", [](const auto& r) { r.number("a"); }, "at /lights/0/a", "a number"},
      {R"({"a": -1})", [](const auto& r) { r.number("a", {.minimum = 0}); }, "/lights/0/a", "of 0 or more"},
      {R"({"a": 1.5})", [](const auto& r) { r.whole("a", 0); }, "/lights/0/a", "an integer"},
      {R"({"a": [1, 2]})", [](const auto& r) { r.at("a").float3(); }, "/lights/0/a", "3 numbers"},
      {R"({"a": [1, "b"]})", [](const auto& r) { r.at("a").numbers(2); }, "/lights/0/a/1", "a number"},
      {R"({"a": ["b", 1]})", [](const auto& r) { r.texts("a"); }, "/lights/0/a/1", "a text"},
      {R"({"a": 1})", [](const auto& r) { r.items("a"); }, "/lights/0/a", "a list"},
      {R"({"a": 1})", [](const auto& r) { r.object("a"); }, "/lights/0/a", "a JSON object"},
      {R"({"a": 1})", [](const auto& r) { r.boolean("a", true); }, "/lights/0/a", "true or false"},
      {"{}", [](const auto& r) { r.choice("shape", kShapes); }, "\"shape\" is missing",
       "\"quad\", \"sphere\""},
      {R"({"shape": "shpere"})", [](const auto& r) { r.choice("shape", kShapes); }, "/lights/0/shape",
       "Try: \"sphere\""},
  };
  for (const Case& each : cases)
    EXPECT_THAT(problem(each.text, each.read), AllOf(HasSubstr(each.place), HasSubstr(each.expected)))
        << each.text;
}

TEST_F(JsonReaderTest, RefusesWhatNobodyAskedForWithTheNearestName) {
  const std::string text = problem(R"({"radius": 1, "colour": 2})", [](const JsonReader& reader) {
    double radius = 0, color = 0;
    reader.read("radius", radius, {});
    reader.read("color", color, {});
    reader.refuseOthers();
  });
  EXPECT_THAT(text, testing::HasSubstr("at /lights/0/colour: unknown key \"colour\""));
  EXPECT_THAT(text, testing::HasSubstr("one of: radius, color"));
  EXPECT_THAT(text, testing::HasSubstr("write \"color\""));
}

TEST_F(JsonReaderTest, AllUnknownKeysAtOnce) {
  const Json json = {{"a", 1}, {"b", 2}, {"c", 3}};
  const std::vector<Error> errors = JsonReader(json, "f").unknownKeys({"b"});
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_EQ(errors[0].place().pointer, "/a");
  EXPECT_EQ(errors[1].place().pointer, "/c");
}

TEST_F(JsonReaderTest, ARemedyOfTheFileIsSaidWhereThereIsNoBetterOne) {
  const Json json = {{"a", {{"b", "x"}}}, {"shape", "quda"}};
  const JsonReader reader(json, "f", "", "export it again");
  const auto remedyOf = [](const auto& read) {
    try {
      read();
    } catch (const Error& error) {
      return error.remedy();
    }
    return std::string("no error");
  };
  EXPECT_EQ(remedyOf([&] { reader.at("a").number("b"); }), "export it again");
  EXPECT_EQ(remedyOf([&] { reader.choice("shape", kShapes); }), "\"quad\"");
}

TEST(Hash, KnowsItsReferenceValues) {
  // XXH3's published values for the empty input.
  EXPECT_EQ(contentHash(std::string_view("")), "99aa06d3014798d86001c324468d497f");
  EXPECT_EQ(checksumHex({}), "2d06800538d394c2");
}

TEST(Hash, OfAFileIsTheHashOfItsBytes) {
  const tests::TemporaryFolder folder;
  const std::string text(3'000'000, 'b');  // more than one block
  writeJson(folder / "small.json", Json("x"));
  writeJson(folder / "large.json", Json(text));
  EXPECT_EQ(contentHashOfFile(folder / "small.json"), contentHash(std::string_view("\"x\"\n")));
  EXPECT_EQ(contentHashOfFile(folder / "large.json"), contentHash("\"" + text + "\"\n"));
}

TEST(StageRecord, RoundTripAndErrors) {
  StageRecord record;
  record.tool = "transfer";
  record.wall_s = 1.5;
  record.peak_memory_bytes = 123456789012;
  record.warnings = {"careful"};
  record.stats = {{"rays", 7}};
  const StageRecord back = stageRecordFromJson(toJson(record), "stats.json");
  EXPECT_EQ(toJson(back), toJson(record));

  Json broken = toJson(record);
  broken["wall_s"] = "long";
  try {
    stageRecordFromJson(broken, "stats.json");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.place().pointer, "/wall_s");
  }
}

}  // namespace
}  // namespace bakelight::formats
