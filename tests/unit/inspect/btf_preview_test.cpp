#include "tools/inspect/btf_preview.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "formats/btf_writer.h"
#include "tools/inspect/inspect.h"

namespace bakelight::inspect {
namespace {

using formats::BtfDirection;

// Red grows with the view's angle, green with the light's; the left half is twice as bright.
std::unique_ptr<formats::Btf> made() {
  formats::BtfInfo info;
  info.views = {{0, 0}, {0.5, 0}, {1, 0}, {1.3, 0}}, info.lights = {{0, 0}, {1.3, 2.356}};
  info.width = 4, info.height = 2;
  std::vector<float> values;
  for (const BtfDirection& view : info.views)
    for (const BtfDirection& light : info.lights)
      for (int t = 0; t < 8; ++t)
        for (const double value : {0.1 + view.polar_rad, 0.1 + light.polar_rad, 0.25})
          values.push_back(static_cast<float>(t % 4 < 2 ? 2 * value : value));
  return formats::btfOf(info, std::move(values));
}

TEST(BtfPreview, ShowsPicturesOfTheNearestDirections) {
  const auto btf = made();
  const BtfSheet sheet = sheetOf(*btf);
  ASSERT_EQ(sheet.pictures.size(), 16U);
  EXPECT_EQ(sheet.pictures[0].view, 0);
  EXPECT_EQ(sheet.pictures[0].light, 0);
  EXPECT_EQ(sheet.pictures[15].view, 3);
  EXPECT_EQ(sheet.pictures[15].light, 1);
  const Preview preview = previewBtf(*btf, sheet, {.size_px = 70});
  EXPECT_EQ(preview.image.width, 4 * 16 + 3 * 2);
  EXPECT_EQ(preview.image.height, 4 * 8 + 3 * 2);
  const auto at = [&](int column, int row) { return preview.image.texel(column * 18 + 12, row * 10 + 4); };
  EXPECT_GT(at(0, 3)[0], 1.5F * at(0, 0)[0]);
  EXPECT_NEAR(at(0, 3)[1], at(0, 0)[1], 1e-4);
  EXPECT_GT(at(3, 0)[1], 1.5F * at(0, 0)[1]);
  EXPECT_GT(preview.image.texel(3, 4)[2], 1.2F * at(0, 0)[2]) << "the left half";
}

TEST(BtfPreview, IsOfAFile) {
  const std::filesystem::path path = testing::TempDir() + "btf_preview_test.btf";
  formats::writeRawBtf(path, *made());
  const Inspection inspection = inspectFile(path, PreviewOptions{.size_px = 64});
  EXPECT_EQ(inspection.summary.kind, "btf");
  EXPECT_EQ(inspection.summary.file_bytes, std::filesystem::file_size(path));
  const formats::Json json = asJson(inspection.summary);
  EXPECT_EQ(json["size"]["layout"], "BDI");
  EXPECT_EQ(json["size"]["pictures"], 8);
  EXPECT_EQ(json["directions"][0]["count"], 4);
  EXPECT_NEAR(json["directions"][0]["largest_polar_deg"].get<double>(), 1.3 * 180 / 3.14159265, 1e-3);
  EXPECT_TRUE(inspection.preview);
}

}  // namespace
}  // namespace bakelight::inspect
