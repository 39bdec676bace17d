#include "tools/stage/frame_options.h"

namespace bakelight::stage {

void declareFrame(Tool& tool, formats::FrameSettings& settings) {
  tool.parameter("width", settings.width_px, {1, 16384}, "px", "width of window or picture")
      .parameter("height", settings.height_px, {1, 16384}, "px", "height of window or picture")
      .parameter("supersampling", settings.supersampling, {1, 4}, "", "subsamples of a pixel along each axis")
      .parameter("yaw_deg", settings.yaw_deg, {-360, 360}, "deg", "camera angle around +Y, 0 stands at +Z")
      .parameter("pitch_deg", settings.pitch_deg, {-89, 89}, "deg", "camera angle above the horizon")
      .parameter("distance", settings.distance, {0.2, 20}, "", "camera distance, 1 just frames the object")
      .parameter("field_of_view_deg", settings.field_of_view_deg, {1, 120}, "deg", "vertical field of view")
      .parameter("light_yaw_deg", settings.light_yaw_deg, {-360, 360}, "deg",
                 "turns the distant light about +Y")
      .parameter("light_pitch_deg", settings.light_pitch_deg, {-360, 360}, "deg", "then turns it about +X")
      .parameter("object_yaw_deg", settings.object_yaw_deg, {-360, 360}, "deg",
                 "turns the object about +Y, under lights that stay")
      .parameter("object_pitch_deg", settings.object_pitch_deg, {-360, 360}, "deg", "then turns it about +X")
      .parameter("time_s", settings.time_s, {0, 1e6}, "s", "where moving emitters are, or start in a window")
      .parameter("background", settings.background, formats::kBackgrounds, "what is seen past the object");
}

}  // namespace bakelight::stage
