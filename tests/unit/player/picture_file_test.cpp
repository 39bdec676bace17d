#include "tools/player/picture_file.h"

#include "formats/error.h"

namespace bakelight::player {
namespace {

TEST(PictureFile, EndingDecidesTheEncoding) {
  EXPECT_EQ(encodingFor("a/b.png"), PictureEncoding::kDisplay);
  EXPECT_EQ(encodingFor("b.EXR"), PictureEncoding::kLinear);
  EXPECT_THROW(encodingFor("b.jpg"), Error);
  EXPECT_THROW(encodingFor("png"), Error);
}

}  // namespace
}  // namespace bakelight::player
