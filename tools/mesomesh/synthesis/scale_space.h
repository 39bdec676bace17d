// An exemplar's channels at other resolutions.
#pragma once

#include "tools/mesomesh/synthesis/exemplar.h"

namespace bakelight::mesomesh {

// Channels on a grid that continues beyond its sides: periodically, or with its border.
struct ChannelGrid {
  int width = 0, height = 0;
  bool periodic = true;
  Samples values;  // width · height × channels

  // Of any column and row.
  Eigen::Index row(int x, int y) const {
    return static_cast<Eigen::Index>(within(y, height)) * width + within(x, width);
  }
  int within(int at, int side) const {
    if (!periodic) return at < 0 ? 0 : at < side ? at : side - 1;
    const int rest = at % side;
    return rest < 0 ? rest + side : rest;
  }
};

// The exemplar without what samples `step` texels apart cannot hold: a level of the Gaussian stack, of full
// resolution (a pyramid would tie coordinates to its grid).
ChannelGrid blurredFor(const Exemplar& exemplar, double step);

// `factor` cells a texel; cell factor · x lies on texel x and has its value (Catmull & Rom 1974).
ChannelGrid upsampled(ChannelGrid grid, int factor);

}  // namespace bakelight::mesomesh
