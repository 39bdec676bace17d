#include "tools/report/thumbnails.h"

#include <algorithm>
#include <cmath>

#include "transport/cpu_renderer.h"

namespace bakelight::report {
namespace {

// Mean over squares of whole pixels; what is left over at the right and lower border is cut off.
formats::Image reduced(const formats::Image& image) {
  const int factor = (image.width + kThumbnailWidth_px - 1) / kThumbnailWidth_px;
  if (factor <= 1 || image.height < factor) return image;
  formats::Image small(image.width / factor, image.height / factor, image.channel_names);
  const std::size_t channels = image.channelCount();
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (std::size_t c = 0; c < channels; ++c) {
        double sum = 0;
        for (int row = y * factor; row < (y + 1) * factor; ++row)
          for (int column = x * factor; column < (x + 1) * factor; ++column)
            sum += image.texel(column, row)[c];
        small.texel(x, y)[c] = static_cast<float>(sum / (factor * factor));
      }
  return small;
}

double positionOf(double difference) {
  return std::sqrt(difference);
}

double rmsOf(const Reference& reference) {
  return std::sqrt(viewErrors(reference, reference, reference.picture).squared_reference);
}

std::string differenceUri(const Picture& picture, const Reference& reference, double end) {
  const formats::Image a = reduced(picture.linear), b = reduced(reference.picture.linear);
  const double rms = rmsOf(reference);
  formats::Image image(a.width, a.height, {"R", "G", "B", "A"});
  for (std::size_t i = 0; i < a.values.size(); i += 4) {
    double squared = 0;
    for (std::size_t c = 0; c < 3; ++c)
      squared += std::pow(static_cast<double>(a.values[i + c]) - b.values[i + c], 2);
    const auto color = differenceColor(rms > 0 ? positionOf(std::sqrt(squared / 3) / rms / end) : 0);
    std::copy(color.begin(), color.end(), image.values.begin() + i);
    image.values[i + 3] = std::max(a.values[i + 3], b.values[i + 3]);
  }
  return formats::pngDataUri(image);
}

std::string pictureUri(const Picture& picture, double exposure) {
  return formats::pngDataUri(
      transport::encodeForDisplay(reduced(picture.linear), static_cast<float>(exposure)));
}

// The least of 1, 2 and 5 times a power of ten that is not below the value.
double roundedUp(double value) {
  if (!(value > 0)) return 1;
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double mantissa : {1, 2, 5})
    if (mantissa * decade >= value) return mantissa * decade;
  return 10 * decade;
}

}  // namespace

std::vector<ShownVariant> shownVariants(const Evaluation& evaluation) {
  const std::vector<std::size_t>& front = evaluation.fronts.frame_ms;
  std::vector<ShownVariant> shown;
  const auto add = [&](std::size_t variant, const char* role) {
    for (ShownVariant& known : shown)
      if (known.variant == variant) {
        known.role += std::string(", ") + role;
        return;
      }
    shown.push_back({variant, role});
  };
  add(front.back(), "most accurate");
  if (front.size() > 2) add(front[front.size() / 2], "between");
  add(front.front(), "fastest");
  add(evaluation.fronts.bytes.front(), "smallest");
  return shown;
}

Thumbnails makeThumbnails(const Plan& plan, const Evaluation& evaluation, Evaluator& evaluator) {
  Thumbnails thumbnails;
  thumbnails.shown = shownVariants(evaluation);
  double largest = 0;
  for (const ShownVariant& shown : thumbnails.shown)
    largest = std::max(largest, evaluation.variants[shown.variant].errors.p99);
  thumbnails.difference_end = roundedUp(largest);

  for (std::size_t view = 0; view < plan.views.size(); ++view) {
    const formats::Image small = reduced(evaluator.truth()[view].picture.linear);
    thumbnails.views.push_back({pictureUri(evaluator.truth()[view].picture, evaluator.exposure(view)),
                                {},
                                {},
                                small.width,
                                small.height});
  }
  for (const ShownVariant& shown : thumbnails.shown) {
    const auto pictures = evaluator.picturesOf(plan.variants[shown.variant].pack);
    for (std::size_t view = 0; view < plan.views.size(); ++view) {
      const Picture& picture = (*pictures)[view].picture;
      thumbnails.views[view].pictures.push_back(pictureUri(picture, evaluator.exposure(view)));
      thumbnails.views[view].differences.push_back(
          differenceUri(picture, evaluator.truth()[view], thumbnails.difference_end));
    }
  }
  return thumbnails;
}

double differenceAt(double position) {
  return position * position;
}

std::array<float, 3> differenceColor(double position) {
  constexpr std::array<std::array<float, 3>, 9> kColors = {{{255, 255, 204},
                                                            {255, 237, 160},
                                                            {254, 217, 118},
                                                            {254, 178, 76},
                                                            {253, 141, 60},
                                                            {252, 78, 42},
                                                            {227, 26, 28},
                                                            {189, 0, 38},
                                                            {128, 0, 38}}};
  const double place = std::clamp(position, 0.0, 1.0) * (kColors.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kColors.size() - 2);
  std::array<float, 3> color;
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = std::lerp(kColors[below][c], kColors[below + 1][c],
                         static_cast<float>(place - static_cast<double>(below))) /
               255;
  return color;
}

}  // namespace bakelight::report
