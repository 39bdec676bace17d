// The parameters of the tool atlas.
#pragma once

#include <string>

#include "tools/atlas/make_atlas.h"
#include "tools/stage/stage.h"

namespace bakelight::atlas {

// Options as they are given: those that are named by a word, or depend on another one.
struct OptionWords {
  std::string texcoords = "new", segmentation = "automatic", parameterization = "free", preset = "few_charts";
  double max_stretch = 0;  // 0: what preset and parameterisation say
  int border = -1;         // −1: 4 for projection, else none
  AtlasOptions options;
};

// `words` outlives the tool's run.
void declareOptions(stage::Tool& tool, OptionWords& words);

AtlasOptions finishedOptions(const OptionWords& words);

}  // namespace bakelight::atlas
