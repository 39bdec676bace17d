// The parameters of the tool atlas.
#pragma once

#include "tools/atlas/make_atlas.h"
#include "tools/stage/stage.h"

namespace bakelight::atlas {

// Options as they are given: some depend on others.
struct GivenOptions {
  bool own_texcoords = false;
  bool low_distortion = false;  // else few charts
  double max_stretch = 0;       // 0: what preset and parameterisation say
  int border = -1;              // −1: 4 for projection, else none
  AtlasOptions options;
};

// `given` outlives the tool's run.
void declareOptions(stage::Tool& tool, GivenOptions& given);

AtlasOptions finishedOptions(const GivenOptions& given);

}  // namespace bakelight::atlas
