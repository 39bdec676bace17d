// Windows against ringing (transport/windowing.h) chosen by the error that they save in what is shown, not by how a light looks: what rings
// in the light may hardly show on a surface, while a window always takes highlights and shadows away.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/pack_contents.h"
#include "tools/report/errors.h"
#include "tools/report/plan.h"
#include "tools/report/renderer.h"

namespace bakelight::report {

// Of pixels that picture and reference cover wholly.
struct WindowError {
  // Root mean square of the difference of display-encoded colors at the player's exposure, relative to that of the reference: dark rings count as they are seen.
  double displayed = 0;
  double radiance = 0;     // rel_rmse: of linear radiance, most of it in highlights
  std::size_t pixels = 0;  // that count
};

struct WindowChoice {
  // The greatest strength whose displayed error is the least but for kWindowSlack; 0 where no window is needed for that.
  double lambda = 0;
  WindowError error;  // with it, over the views of the light
  WindowError without;
};
// Of the least error, relative: where errors are that alike, rings offend more than softness.
inline constexpr double kWindowSlack = 0.05;

// Pictures of one pack under one light, each band of the distant light by itself (near light goes with the first): a window is a weighted sum.
class WindowFit {
 public:
  // `exposure`: the player's factor on radiance.
  void add(const Reference& truth, std::vector<Picture> bands, double exposure);
  WindowError errorAt(double lambda) const;
  // Among 0 and strengths from 1e-5 to 1, a factor of √2 apart.
  WindowChoice choose() const;
  Picture pictureAt(std::size_t view, double lambda) const;

 private:
  struct View {
    Reference truth;
    std::vector<Picture> bands;
    double exposure;
  };
  std::vector<View> views_;
};

struct WindowedPictures {
  std::vector<Picture> pictures;      // a view
  std::vector<WindowChoice> windows;  // a view; those of one light are the same
};
// `exposures`: a view. Of the plan's views, which are taken to be without a window of their own; nothing for a pack that takes its light in another form than spherical
// harmonics. With the ground that a pack stands on, where the reference shows it, too. Cost: a light change and a picture for each band and view.
std::optional<WindowedPictures> measureWindows(const formats::Pack& pack, const Plan& plan,
                                               Renderer& renderer, const std::vector<Reference>& truth,
                                               const std::vector<double>& exposures);

}  // namespace bakelight::report
