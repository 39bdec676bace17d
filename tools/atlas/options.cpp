#include "tools/atlas/options.h"

#include "formats/error.h"

namespace bakelight::atlas {
namespace {

// What filter kernels of 9 × 9 texels reach beyond a chart's edge.
constexpr int kProjectionBorder = 4;

constexpr formats::Word<bool> kTexcoords[] = {{"new", false}, {"own", true}};
constexpr formats::Word<bool> kSegmentations[] = {{"automatic", false}, {"cuts", true}};
constexpr formats::Word<Parameterization> kParameterizations[] = {
    {"free", Parameterization::kFree},
    {"convex", Parameterization::kConvex},
    {"projection", Parameterization::kProjection}};
constexpr formats::Word<bool> kPresets[] = {{"few_charts", false}, {"low_distortion", true}};

}  // namespace

void declareOptions(stage::Tool& tool, GivenOptions& given) {
  AtlasOptions& options = given.options;
  tool.parameter("texcoords", given.own_texcoords, kTexcoords,
                 "Whether the mesh's own texture coordinates are taken: an error if they are no valid atlas")
      .parameter("segmentation", options.cuts_only, kSegmentations,
                 "Charts: automatic, within what cuts and creases leave; or just what the cuts leave")
      .parameter("parameterisation", options.parameterization, kParameterizations,
                 "Charts with free borders and least distortion, convex polygons on a circle, or "
                 "orthographic projections")
      .parameter("preset", given.low_distortion, kPresets, "What max_stretch 0 stands for")
      .parameter("max_stretch", given.max_stretch, {0, 100}, "",
                 "Largest L2 stretch of a chart, 1 = none, 4 times as much above 1 where it has less than "
                 "1/400 of the area; 0: by preset (free "
                 "borders 1.04, 1.005; convex "
                 "1.25, 1.1)")
      .parameter(
          "straightness", options.straightness, {0, 100}, "",
          "Free borders: how far the teeth of borders are drawn flat, for tighter packing; 0: as they are")
      .parameter("crease_angle_deg", options.crease_angle_deg, {0, 180}, "deg",
                 "Edges sharper than this separate charts where they close up")
      .parameter("normal_threshold_deg", options.normal_threshold_deg, {1, 80}, "deg",
                 "Projection: largest angle of a triangle to the chart's mean normal")
      .parameter("corners", options.corners, {3, 64}, "",
                 "Convex: corners of a polygon where the cuts choose none")
      .parameter("resolution", options.resolution, {16, 16384}, "texels", "Side of the square")
      .parameter("gutter", options.gutter, {0, 64}, "texels", "Free ones between any two charts")
      .parameter(
          "border", given.border, {-1, 64}, "texels",
          "Around each chart, its own, with the neighbouring surface in them; -1: 4 for projection, else 0");
}

AtlasOptions finishedOptions(const GivenOptions& given) {
  AtlasOptions options = given.options;
  if (given.max_stretch > 0 && given.max_stretch < 1)
    throw Error(ExitStatus::kUsage, {"", "max_stretch", ""}, "no chart has an L2 stretch below 1",
                "1 or more, or 0 for what the preset says");
  const bool is_convex = options.parameterization == Parameterization::kConvex, is_low = given.low_distortion;
  options.max_stretch = given.max_stretch > 0 ? given.max_stretch
                        : is_convex           ? (is_low ? kLowDistortionPolygons : kFewPolygons)
                                              : (is_low ? kLowDistortion : kFewCharts);
  options.border = given.border >= 0                                           ? given.border
                   : options.parameterization == Parameterization::kProjection ? kProjectionBorder
                                                                               : 0;
  return options;
}

}  // namespace bakelight::atlas
