// What files of measured BRDFs are read into.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tools/brdf/brdf.h"

namespace bakelight::brdf {

struct MeasuredBrdf {
  Brdf brdf;
  // √(Σ(f − its mean over turns about the normal)² / Σ f²): 0 for isotropic ones. What projecting takes away.
  double anisotropy = 0;
  std::vector<std::string> notes;  // what was averaged, converted or dropped
};

}  // namespace bakelight::brdf
