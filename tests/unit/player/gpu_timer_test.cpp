#include "tools/player/gl/gpu_timer.h"

#include <chrono>

#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/picture_target.h"

namespace bakelight::player {
namespace {

class GpuTimerTest : public testing::Test {
 protected:
  // Draws `pixels`² of subsamples and resolves them, which is a pass.
  void resolve(int pixels) {
    target_.resize(pixels, pixels, 2);
    target_.beginFrame(1);
    const ResolvedPicture picture(PictureEncoding::kDisplay, pixels, pixels);
    target_.resolve(picture, 1);
  }

  HeadlessContext context_;
  PictureTarget target_;
};

TEST_F(GpuTimerTest, TellsPassesByNameInTheirOrderAndAddsUpThoseOfOneName) {
  GpuTimer timer;
  timer.start(GpuTimer::Of::kPasses);
  { const GpuPass pass("first"); }
  resolve(64);
  { const GpuPass pass("first"); }
  const GpuTimes times = timer.finish();
  ASSERT_EQ(times.passes_ms.size(), 2u);
  EXPECT_EQ(times.passes_ms[0].first, "first");
  EXPECT_EQ(times.passes_ms[1].first, "resolve");
  EXPECT_GE(times.passes_ms[0].second, 0);
  EXPECT_GT(times.total_ms, 0);
  EXPECT_LE(times.passes_ms[0].second + times.passes_ms[1].second, times.total_ms + 1e-6);
}

TEST_F(GpuTimerTest, TheGpusTimeIsThatOfItsWork) {
  const auto start = std::chrono::steady_clock::now();
  GpuTimer timer;
  timer.start(GpuTimer::Of::kPasses);
  resolve(512);
  const GpuTimes times = timer.finish();
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
  ASSERT_EQ(times.passes_ms.size(), 1u);
  // A million texels are read: more than a microsecond's work of any GPU, and no more than we waited for.
  EXPECT_GT(times.passes_ms[0].second, 1e-3);
  EXPECT_LE(times.total_ms, 1.01 * wall.count() + 0.01) << "two clocks";
}

TEST_F(GpuTimerTest, TheTotalIsTakenWithoutTellingPassesApart) {
  GpuTimer timer;
  timer.start(GpuTimer::Of::kTotal);
  resolve(64);
  const GpuTimes times = timer.finish();
  EXPECT_GT(times.total_ms, 0);
  EXPECT_TRUE(times.passes_ms.empty());
}

TEST_F(GpuTimerTest, WithoutATimerPassesCostNothingAndAFinishedOneForgets) {
  resolve(8);
  GpuTimer timer;
  EXPECT_TRUE(timer.finish().passes_ms.empty());
  timer.start(GpuTimer::Of::kPasses);
  resolve(8);
  EXPECT_EQ(timer.finish().passes_ms.size(), 1u);
  resolve(8);
  timer.start(GpuTimer::Of::kPasses);
  EXPECT_TRUE(timer.finish().passes_ms.empty());
  {
    GpuTimer forgotten;
    forgotten.start(GpuTimer::Of::kPasses);
  }
  resolve(8);
  throwIfGlFailed("playing without a timer");
}

}  // namespace
}  // namespace bakelight::player
