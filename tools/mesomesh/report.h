// What a run tells, for stats.json and for a table of its own.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "formats/json.h"
#include "tools/mesomesh/field/direction_field.h"
#include "tools/mesomesh/retile/retile.h"

namespace bakelight::mesomesh {

formats::Json toJson(const RetileReport& retiling, const DirectionField& field);

// {"symmetry": n, "singularities": [{"point": [x, y, z], "index": ±k/n}]}: the middles of their triangles, and
// turns.
formats::Json singularityTable(const formats::TriangleMesh& mesh, const DirectionField& field, int symmetry);

}  // namespace bakelight::mesomesh
