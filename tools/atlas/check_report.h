// What atlas_check tells: figures by name, for stats.json and for people.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "formats/json.h"
#include "tools/atlas/check.h"

namespace bakelight::atlas {

// By their names in stats.json.
std::vector<std::pair<std::string, formats::Json>> figuresOf(const AtlasFigures& figures);

struct CheckReport {
  std::vector<std::pair<std::string, formats::Json>> figures;
  std::int64_t defects = 0;
  int gutter_shortfall = 0;  // texels by which the smallest gutter is too small; never negative

  bool isValid() const { return defects == 0 && gutter_shortfall == 0; }
};

// Besides the figures: defects, gutter_shortfall, and their sum, shortcomings, which recipes ask for.
// A mesh without texture coordinates is no atlas, and no mistake: has_texcoords is false then, each triangle
// is a defect, the whole gutter is short and there are no other figures. Throws what check() throws else.
CheckReport reportOf(const formats::TriangleMesh& mesh, int resolution, int gutter, const std::string& file);

// Aligned, a figure a line.
std::string asText(const CheckReport& report);

}  // namespace bakelight::atlas
