#include "formats/frame_settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

using testing::HasSubstr;

std::string errorOf(const Json& json) {
  try {
    frameSettingsFromJson(json, "plan.json", "/views/0/frame");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(FrameSettings, ComeBackFromJson) {
  FrameSettings settings;
  settings.width_px = 123;
  settings.height_px = 45;
  settings.supersampling = 3;
  settings.yaw_deg = -12.25;
  settings.pitch_deg = 1.0 / 3;
  settings.distance = 1.5;
  settings.field_of_view_deg = 50;
  settings.light_yaw_deg = 30;
  settings.light_pitch_deg = -40;
  settings.object_yaw_deg = 70;
  settings.object_pitch_deg = 80;
  settings.time_s = 2.5;
  settings.auto_exposure = false;
  settings.exposure_ev = -1;
  settings.background = Background::kTransparent;
  const Json json = toJson(settings);
  EXPECT_EQ(json.size(), 15U);
  EXPECT_EQ(json.at("background"), "transparent");
  const FrameSettings read = frameSettingsFromJson(Json::parse(json.dump()), "", "");
  EXPECT_EQ(toJson(read), json);
  EXPECT_EQ(read.pitch_deg, settings.pitch_deg);
  EXPECT_EQ(read.background, Background::kTransparent);
  EXPECT_NE(toJson(FrameSettings()), json);
}

TEST(FrameSettings, WhatIsMissingKeepsItsDefault) {
  const FrameSettings read = frameSettingsFromJson({{"width", 64}}, "", "");
  EXPECT_EQ(read.width_px, 64);
  EXPECT_EQ(read.height_px, FrameSettings().height_px);
  EXPECT_EQ(read.yaw_deg, FrameSettings().yaw_deg);
}

TEST(FrameSettings, RefusesWhatThePlayerWouldRefuse) {
  const std::string unknown = errorOf({{"yaw", 3}});
  EXPECT_THAT(unknown, HasSubstr("plan.json"));
  EXPECT_THAT(unknown, HasSubstr("/views/0/frame/yaw"));
  EXPECT_THAT(errorOf({{"pitch_dg", 3}}), HasSubstr("pitch_deg"));
  EXPECT_THAT(errorOf({{"pitch_deg", 90}}), HasSubstr("/views/0/frame/pitch_deg"));
  EXPECT_THAT(errorOf({{"width", 0}}), HasSubstr("/width"));
  EXPECT_THAT(errorOf({{"width", 1.5}}), HasSubstr("/width"));
  EXPECT_THAT(errorOf({{"background", "red"}}), HasSubstr("transparent"));
  EXPECT_THAT(errorOf(Json::array()), HasSubstr("/views/0/frame"));
}

}  // namespace
}  // namespace bakelight::formats
