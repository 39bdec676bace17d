#include "formats/json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/hash.h"
#include "formats/stage_record.h"
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
