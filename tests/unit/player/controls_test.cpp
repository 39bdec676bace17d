#include "tools/player/controls.h"

namespace bakelight::player {
namespace {

TEST(Controls, DraggingRightShowsTheObjectsLeftSide) {
  formats::FrameSettings settings{.yaw_deg = 0, .pitch_deg = 0};
  const transport::BoundingSphere unit{{0, 0, 0}, 1};
  dragOrbit(settings, 100, 0);
  EXPECT_LT(transport::frameCamera(settings, unit).eye().x(),
            0);  // the camera went to −X, so the front went right
  dragOrbit(settings, 0, 100);
  EXPECT_GT(transport::frameCamera(settings, unit).eye().y(), 0);
}

TEST(Controls, PitchStopsShortOfThePoles) {
  formats::FrameSettings settings;
  dragOrbit(settings, 0, 1e6);
  EXPECT_EQ(settings.pitch_deg, 89);
  dragOrbit(settings, 0, -1e6);
  EXPECT_EQ(settings.pitch_deg, -89);
}

TEST(Controls, LightFromTheFrontFollowsThePointer) {
  formats::FrameSettings settings;
  dragLight(settings, 100, 0);
  EXPECT_GT((transport::worldFromLight(settings) * transport::Vec3::UnitZ()).x(), 0);
  settings = {};
  dragLight(settings, 0, 100);
  EXPECT_LT((transport::worldFromLight(settings) * transport::Vec3::UnitZ()).y(), 0);
}

TEST(Controls, ObjectsFrontFollowsThePointer) {
  formats::FrameSettings settings;
  dragObject(settings, 100, 0);
  EXPECT_GT((transport::worldFromObject(settings) * transport::Vec3::UnitZ()).x(), 0);
  EXPECT_TRUE(transport::worldFromLight(settings).isIdentity());
  settings = {};
  dragObject(settings, 0, 100);
  EXPECT_LT((transport::worldFromObject(settings) * transport::Vec3::UnitZ()).y(), 0);
}

TEST(Controls, ZoomGoesInAndOutByTheSameFactorWithinItsRange) {
  formats::FrameSettings settings;
  zoom(settings, 1);
  EXPECT_NEAR(settings.distance, 0.9, 1e-12);
  zoom(settings, -1);
  EXPECT_NEAR(settings.distance, 1, 1e-12);
  zoom(settings, 1000);
  EXPECT_EQ(settings.distance, 0.2);
  zoom(settings, -1000);
  EXPECT_EQ(settings.distance, 20);
}

}  // namespace
}  // namespace bakelight::player
