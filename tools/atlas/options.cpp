#include "tools/atlas/options.h"

#include "formats/error.h"

namespace bakelight::atlas {
namespace {

// What filter kernels of 9 × 9 texels reach beyond a chart's edge.
constexpr int kProjectionBorder = 4;

}  // namespace

void declareOptions(stage::Tool& tool, OptionWords& words) {
  AtlasOptions& options = words.options;
  tool.parameter("texcoords", words.texcoords, {"new", "own"},
                 "Whether the mesh's own texture coordinates are taken: an error if they are no valid atlas")
      .parameter("segmentation", words.segmentation, {"automatic", "cuts"},
                 "Charts: automatic, within what cuts and creases leave; or just what the cuts leave")
      .parameter("parameterisation", words.parameterization, {"free", "convex", "projection"},
                 "Charts with free borders and least distortion, convex polygons on a circle, or "
                 "orthographic projections")
      .parameter("preset", words.preset, {"few_charts", "low_distortion"}, "What max_stretch 0 stands for")
      .parameter("max_stretch", words.max_stretch, {0, 100}, "",
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
          "border", words.border, {-1, 64}, "texels",
          "Around each chart, its own, with the neighbouring surface in them; -1: 4 for projection, else 0");
}

AtlasOptions finishedOptions(const OptionWords& words) {
  AtlasOptions options = words.options;
  if (words.max_stretch > 0 && words.max_stretch < 1)
    throw Error(ExitStatus::kUsage, {"", "max_stretch", ""}, "no chart has an L2 stretch below 1",
                "1 or more, or 0 for what the preset says");
  options.cuts_only = words.segmentation == "cuts";
  options.parameterization = words.parameterization == "convex"       ? Parameterization::kConvex
                             : words.parameterization == "projection" ? Parameterization::kProjection
                                                                      : Parameterization::kFree;
  const bool is_convex = options.parameterization == Parameterization::kConvex,
             is_low = words.preset == "low_distortion";
  options.max_stretch = words.max_stretch > 0 ? words.max_stretch
                        : is_convex           ? (is_low ? kLowDistortionPolygons : kFewPolygons)
                                              : (is_low ? kLowDistortion : kFewCharts);
  options.border = words.border >= 0                                           ? words.border
                   : options.parameterization == Parameterization::kProjection ? kProjectionBorder
                                                                               : 0;
  return options;
}

}  // namespace bakelight::atlas
