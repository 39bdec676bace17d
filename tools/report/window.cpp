#include "tools/report/window.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "transport/color.h"
#include "transport/windowing.h"

namespace bakelight::report {
namespace {

constexpr double kLeastLambda = 1e-5, kGreatestLambda = 1;

bool isOfOneLight(const PlanView& a, const PlanView& b) {
  return a.environment_path == b.environment_path && a.lights_path == b.lights_path;
}

}  // namespace

void WindowFit::add(const Reference& truth, std::vector<Picture> bands, double exposure) {
  views_.push_back({truth, std::move(bands), exposure});
}

Picture WindowFit::pictureAt(std::size_t view, double lambda) const {
  const std::vector<Picture>& bands = views_[view].bands;
  Picture sum = bands.front();
  for (std::size_t band = 1; band < bands.size(); ++band) {
    const auto factor = static_cast<float>(transport::bandFactor(static_cast<int>(band), lambda));
    const std::vector<float>& values = bands[band].linear.values;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (i % 4 != 3) sum.linear.values[i] += factor * values[i];
  }
  return sum;
}

WindowError WindowFit::errorAt(double lambda) const {
  std::vector<double> displayed, radiance;
  std::size_t pixels = 0;
  for (std::size_t view = 0; view < views_.size(); ++view) {
    const auto& [truth, bands, exposure] = views_[view];
    Picture picture = pictureAt(view, lambda);
    double difference = 0, square = 0;
    for (std::size_t pixel = 0; pixel < picture.covered.size(); ++pixel) {
      if (picture.covered[pixel] == 0 || truth.picture.covered[pixel] == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto encoded = [&, factor = static_cast<float>(exposure)](const Picture& of) {
          return static_cast<double>(transport::srgbFromLinear(factor * of.linear.values[4 * pixel + c]));
        };
        const double right = encoded(truth.picture);
        difference += std::pow(encoded(picture) - right, 2);
        square += right * right;
      }
    }
    displayed.push_back(square > 0 ? std::sqrt(difference / square) : 0);
    const ViewErrors errors = viewErrors(truth, {std::move(picture), {}}, truth.picture);
    radiance.push_back(errors.relativeRmse());
    pixels += errors.pixels;
  }
  return {rootMeanSquare(displayed), rootMeanSquare(radiance), pixels};
}

WindowChoice WindowFit::choose() const {
  std::map<double, WindowError> errors = {{0, errorAt(0)}};  // by strength
  for (double lambda = kLeastLambda; lambda <= kGreatestLambda; lambda *= std::sqrt(2.0))
    errors[lambda] = errorAt(lambda);
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [lambda, error] : errors) least = std::min(least, error.displayed);
  const auto isLeast = [&](const WindowError& error) {
    return error.displayed <= (1 + kWindowSlack) * least;
  };
  WindowChoice choice{0, errors.at(0), errors.at(0)};
  if (isLeast(choice.without)) return choice;
  for (const auto& [lambda, error] : errors)
    if (isLeast(error)) choice.lambda = lambda, choice.error = error;
  return choice;
}

std::optional<WindowedPictures> measureWindows(const formats::Pack& pack, const Plan& plan,
                                               Renderer& renderer, const std::vector<Reference>& truth,
                                               const std::vector<double>& exposures) {
  const int order = transport::makePackShading(pack)->needs().sh_order;
  if (order == 0) return std::nullopt;
  std::vector<std::vector<Picture>> bands(plan.views.size());
  for (int band = 0; band < order; ++band) {
    std::vector<Renderer::Conditions> conditions_of(bands.size());
    std::vector<Picture> pictures = renderer.picturesOf(
        pack, [&](std::size_t view, Renderer::Conditions conditions, transport::PackShading& shading) {
          for (std::size_t i = 0; i < conditions.distant.size(); ++i) {
            const auto of = static_cast<int>(std::sqrt(static_cast<double>(i)));
            if (of != band) conditions.distant[i] = {0, 0, 0};
          }
          if (band > 0) {
            for (transport::Float3& coefficient : conditions.near) coefficient = {0, 0, 0};
            conditions.punctual.clear();
          }
          conditions.light(shading);
          conditions_of[view] = std::move(conditions);
        });
    for (std::size_t view = 0; view < bands.size(); ++view) {
      renderer.addGround(pack, view, conditions_of[view], truth[view].picture, pictures[view]);
      bands[view].push_back(std::move(pictures[view]));
    }
  }
  WindowedPictures result;
  result.pictures.resize(bands.size());
  result.windows.resize(bands.size());
  std::vector<bool> done(bands.size(), false);
  for (std::size_t first = 0; first < bands.size(); ++first) {
    if (done[first]) continue;
    WindowFit fit;
    std::vector<std::size_t> views;
    for (std::size_t view = first; view < bands.size(); ++view)
      if (isOfOneLight(plan.views[first], plan.views[view])) {
        fit.add(truth[view], std::move(bands[view]), exposures[view]);
        views.push_back(view);
        done[view] = true;
      }
    const WindowChoice choice = fit.choose();
    for (std::size_t i = 0; i < views.size(); ++i) {
      result.pictures[views[i]] = fit.pictureAt(i, choice.lambda);
      result.windows[views[i]] = choice;
    }
  }
  return result;
}

}  // namespace bakelight::report
