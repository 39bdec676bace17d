// What texels give each other, and what they give to the knots of their triangle in place of what smoothing took from these
// (Lensch et al. 2002, section 5.4).
//
// Where the printed method takes R_d between vertices with a diagonal of 0 and fits three weights to the ring of a 9 × 9 kernel, factors here
// are smooth (throughput.h), and the weights are fitted to all texels under the hats of the three knots that the 7 × 7 kernels do not
// reach, so that their sum is right above all: by the ring alone it errs by 7 % for vertices 4 texels apart and by 24–35 % for 8.
#pragma once

#include <functional>
#include <vector>

#include "tools/kernels/texels.h"
#include "tools/kernels/throughput.h"

namespace bakelight::kernels {

struct Blending {
  // Of each texel: what it gives to the three knots, per area; 3 × RGB.
  std::vector<std::array<Rgb, 3>> densities;
  // Texels that light leaves: indices, ascending.
  std::vector<std::uint32_t> receivers;
  // Of each of these: 49 texels × RGB, rows from the top.
  std::vector<float> kernels;
  std::size_t rank_deficient = 0;  // texels whose weights are the least of many that fit
  std::size_t clamped = 0;         // texels that would have given a knot more than twice what falls on them
  double fit_seconds = 0, kernel_seconds = 0;
  double window_share = 0;  // of the response to even light, by kernels; mean over receivers and colors
};

// Cost: texels · (49 + those under the hats) · 3. Threads by TBB, same bytes for any number.
Blending blend(const Knots& knots, const Texels& texels, const Reflectance& reflectance,
               const Throughput& throughput, const std::function<void(std::size_t triangles)>& progress);

}  // namespace bakelight::kernels
