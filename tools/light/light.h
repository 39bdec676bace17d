// The light stage: a light rig as one vector of SH coefficients, and what a person wants to know of it.
#pragma once

#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/light_rig.h"
#include "formats/tensors.h"
#include "tools/stage/stage.h"
#include "transport/light_rig.h"

namespace bakelight::light {

// One distant light by itself, before windowing.
struct LightShare {
  std::string type;                   // as in the rig's JSON: "disk", "sky", …
  formats::Float3 scalar_irradiance;  // ∫ L dω; what a surface that faces a small light receives
  double energy_share;                // of the sum of all lights' scalar irradiances (luminance), 0–1
};

struct LightFigures {
  std::vector<LightShare> lights;
  formats::Float3 mean_radiance;  // over the sphere
  // Least luminance of the reconstructed light over its mean, on 8,192 directions; below 0 it rings. 0 for
  // no light.
  double minimum_over_mean = 0;
};
LightFigures figuresOf(const formats::LightRig& rig, const transport::ShLight& light);

// Tensor "light", F32, order² × RGB; with order, basis, window and moved_energy as metadata.
formats::TensorFile tensorFile(const transport::RigLight& light, int order);

// Two lat-long images, one above the other: the lights themselves, and what the SH coefficients make of them
// (negative where they ring).
formats::Image preview(const transport::RigLight& light, int order);

void report(const transport::RigLight& light, const LightFigures& figures, const formats::LightRig& rig,
            stage::Run& run);

}  // namespace bakelight::light
