#include "tools/inspect/summary.h"

namespace bakelight::inspect {
namespace {

Summary example() {
  Summary summary{"a.ply", "mesh", 1234567, {}};
  summary.sections = {
      {"size", {{"vertices", 34835, ""}, {"angle_deg", 12.5, "deg"}, {"volume", nullptr, ""}}, {}, {}},
      {"per_band", {}, {"band", "share_percent"}, {{0, 99.25}, {10, 0.75}}}};
  return summary;
}

TEST(Summary, TextIsAlignedGroupedAndHasUnits) {
  EXPECT_EQ(asText(example()),
            "a.ply: mesh, 1,234,567 bytes\n"
            "\n"
            "size\n"
            "  vertices  34,835\n"
            "  angle     12.5 deg\n"
            "  volume    -\n"
            "\n"
            "per band\n"
            "  band  share percent\n"
            "     0          99.25\n"
            "    10           0.75\n");
}

TEST(Summary, JsonKeepsNamesAndNumbers) {
  EXPECT_EQ(asJson(example()), formats::Json::parse(R"({
    "file": "a.ply", "kind": "mesh", "file_bytes": 1234567,
    "size": {"vertices": 34835, "angle_deg": 12.5, "volume": null},
    "per_band": [{"band": 0, "share_percent": 99.25}, {"band": 10, "share_percent": 0.75}]})"));
}

TEST(Summary, NegativeAndShortNumbersAreGroupedRightly) {
  Summary summary{"f", "mesh", 999, {{"n", {{"a", -123456, ""}, {"b", -123, ""}, {"c", 1000, ""}}, {}, {}}}};
  EXPECT_EQ(asText(summary), "f: mesh, 999 bytes\n\nn\n  a  -123,456\n  b  -123\n  c  1,000\n");
}

}  // namespace
}  // namespace bakelight::inspect
