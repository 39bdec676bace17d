// How much a patch looks otherwise from elsewhere.
#pragma once

#include "formats/radiance_transfer_texture.h"

namespace bakelight::rtt {

// Norms are over texels, coefficients and colors (of light whose coefficients are independent and alike), and over views
// by their cosine, as light leaves through the mid-plane: ‖X‖² = Σ_v cos θ_v ‖X(v)‖² ÷ Σ_v cos θ_v.
struct ViewDependence {
  double from_mean = 0;  // ‖B − mean of B over the views‖ ÷ ‖B‖: what the best one view for all would miss
  double from_head_on =
      0;  // the same with the view from straight above (linear between its neighbors) for the mean
};

// Of every fourth texel a side where there are 32 or more across, else of all.
ViewDependence viewDependence(const formats::RadianceTransferTexture& texture);

}  // namespace bakelight::rtt
