#include "tools/player/gl/gl_context.h"

#include <cstdlib>
#include <string>

#include "formats/error.h"
#include "tools/player/gl/gl_objects.h"

namespace bakelight::player {
namespace {

class GlContextTest : public testing::Test {
 protected:
  void SetUp() override { ::unsetenv("BAKELIGHT_GL_DEBUG"); }
  void TearDown() override { ::unsetenv("BAKELIGHT_GL_DEBUG"); }

  static bool isDebugContext() {
    GLint flags = 0;
    glGetIntegerv(GL_CONTEXT_FLAGS, &flags);
    return (flags & GL_CONTEXT_FLAG_DEBUG_BIT) != 0;
  }

  // What is said of a call that GL refuses.
  static std::string refusal() {
    glEnable(GL_TEXTURE_CUBE_MAP_NEGATIVE_X);
    try {
      throwIfGlFailed("trying");
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(GlContextTest, ErrorsComeThroughWithoutADebugContext) {
  const HeadlessContext context;
  EXPECT_FALSE(isDebugContext());
  EXPECT_THAT(refusal(), testing::HasSubstr("while trying: invalid enumeration"));
  throwIfGlFailed("doing nothing after it");
}

TEST_F(GlContextTest, TheDriversWordsComeOnRequestAlone) {
  for (const char* wish : {"0", "", "1"}) {
    ASSERT_EQ(::setenv("BAKELIGHT_GL_DEBUG", wish, 1), 0);
    const HeadlessContext context;
    EXPECT_EQ(isDebugContext(), std::string(wish) == "1") << wish;
    EXPECT_THAT(refusal(), testing::HasSubstr("while trying: "));
  }
}

TEST_F(GlContextTest, ContextsFollowOneAnother) {
  for (int i = 0; i < 3; ++i) {
    const HeadlessContext context;
    EXPECT_NE(glRendererName().find("OpenGL 4."), std::string::npos) << glRendererName();
  }
}

}  // namespace
}  // namespace bakelight::player
