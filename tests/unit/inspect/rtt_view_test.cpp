#include "tools/inspect/rtt_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "tests/support/temporary_folder.h"
#include "tools/inspect/file_kind.h"
#include "tools/inspect/inspect.h"

namespace bakelight::inspect {
namespace {

formats::RadianceTransferTexture texture(const std::string& material, float albedo) {
  formats::RadianceTransferTexture made{
      .material = material, .order = 2, .views = 2, .width = 4, .height = 4};
  made.allocate();
  for (int view = 0; view < 4; ++view)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          made.response(view % 2, view / 2, x, y)[c * 4] =
              albedo / std::sqrt(4 * std::numbers::pi_v<float>) * (view == 3 ? 2 : 1);
  return made;
}

TEST(RttView, FileIsKnownDescribedAndDrawn) {
  const tests::TemporaryFolder folder;
  const auto file = folder.path() / "rtt.exr";
  formats::writeRadianceTransferTextures(file, std::vector{texture("", 0.4F), texture("lid", 0.2F)},
                                         formats::ExrPrecision::kFloat);
  EXPECT_EQ(kindOfFile(file), FileKind::kRtt);
  PreviewOptions options;
  options.size_px = 16;
  const Inspection inspection = inspectFile(file, options);
  EXPECT_EQ(inspection.summary.kind, "rtt");
  const Section& first = inspection.summary.sections.at(0);
  EXPECT_EQ(first.name, "texture");
  EXPECT_EQ(first.figures.at(2).value, 4);
  // Of equally weighed views three have 0.4 and one 0.8.
  EXPECT_NEAR(first.figures.at(4).value.at(0).get<double>(), 0.5, 1e-6);
  EXPECT_EQ(inspection.summary.sections.at(2).name, "texture lid");
  ASSERT_TRUE(inspection.preview);
  EXPECT_EQ(inspection.preview->image.height, 16);
  // Column 1, row 1 is at the upper right; it is brighter.
  EXPECT_GT(inspection.preview->image.texel(6, 1)[0], inspection.preview->image.texel(1, 1)[0]);
  EXPECT_GT(inspection.preview->image.texel(1, 6)[0], inspection.preview->image.texel(1, 14)[0]);
}

}  // namespace
}  // namespace bakelight::inspect
