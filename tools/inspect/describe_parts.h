// Pieces that the descriptions of several kinds of file share.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/json.h"
#include "formats/triangle_mesh.h"
#include "tools/inspect/summary.h"

namespace bakelight::inspect {

// By the shortest decimal text of the float: 0.8f is 0.8 and not 0.800000011920929. Finite values only.
formats::Json numberOf(float value);
formats::Json listOf(const formats::Float3& v);

// Energy of transfer vectors by SH band; `vectors` is n × order², and the three colours of a coloured table
// count as rows of their own.
Section bandSection(const std::string& name, std::span<const float> vectors, int order);

}  // namespace bakelight::inspect
