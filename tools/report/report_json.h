// report.json (docs/REPORT.md has the keys).
#pragma once

#include "formats/json.h"
#include "tools/report/evaluation.h"
#include "tools/report/plan.h"

namespace bakelight::report {

formats::Json reportJson(const Plan& plan, const Evaluation& evaluation);

}  // namespace bakelight::report
