// The stage's figures as stats.json shows them.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/simplify/simplify.h"

namespace bakelight::simplify {

// Members by name, units in the names; counts of repairs under "repairs", times under "seconds".
nlohmann::json toJson(const SimplifyReport& report);

}  // namespace bakelight::simplify
