// Small pictures of a few variants beside their references, with images of the difference.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/report/evaluation.h"
#include "tools/report/plan.h"

namespace bakelight::report {

// A few variants of the front of error against milliseconds a frame, and why each was taken.
struct ShownVariant {
  std::size_t variant;
  std::string role;  // "most accurate"
};
std::vector<ShownVariant> shownVariants(const Evaluation& evaluation);

struct Thumbnails {
  std::vector<ShownVariant> shown;
  // The difference that has the last colour, in units of the reference's rms.
  double difference_end = 0;
  struct View {
    std::string reference;                           // URIs of PNG images, formats::pngDataUri
    std::vector<std::string> pictures, differences;  // of each shown variant
    int width_px = 0, height_px = 0;
  };
  std::vector<View> views;
};

inline constexpr int kThumbnailWidth_px = 320;  // at most

// Pictures are exposed as the player does; differences are √(mean over colours of Δ²) ÷ rms of the reference,
// transparent where neither picture shows anything.
Thumbnails makeThumbnails(const Plan& plan, const Evaluation& evaluation, Evaluator& evaluator);

// Colours of differences: `position` 0 is pale yellow, 1 dark red, and lightness falls steadily between them,
// so that it prints in grey (ColorBrewer's YlOrRd). Display-encoded, 0–1.
std::array<float, 3> differenceColor(double position);
// The difference that stands at a position, as a share of Thumbnails::difference_end: its square, as a good
// variant's differences would not be seen beside a bad one's otherwise.
double differenceAt(double position);

}  // namespace bakelight::report
