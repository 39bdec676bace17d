// A budget of an asset, and the variant that keeps it at the least cost.
#pragma once

#include <optional>
#include <string>

#include "formats/error.h"
#include "formats/json.h"

namespace bakelight::pipeline {

// Limits, inclusive, at least one: of the relative error (rel_rmse, above 0), of milliseconds a frame on the
// CPU, of the pack's bytes.
struct Budget {
  std::optional<double> error, frame_ms, bytes;
};

// From asset.json's "budget". Throws ProblemsFound or Error(kBadInput) at `place`.
Budget parseBudget(const formats::Json& json, const ErrorPlace& place);

// Chooses among the variants of a report (report.json of the tool `report`): of those that keep all limits
// the cheapest if the error is limited, else the one of least error. Cost is milliseconds a frame, or bytes
// if those alone are limited besides the error. Ties go to the smaller pack, then to the first name. Returns
// { limits, chosen, parameters, rel_rmse, frame_ms, bytes, why, next_better, next_cheaper }; the neighbours
// on the front of error against cost are { name, rel_rmse, frame_ms, bytes } or null. Throws Error(kBadInput)
// at `place` if no variant keeps the budget, with the one that comes nearest.
formats::Json chooseVariant(const Budget& budget, const formats::Json& report, const ErrorPlace& place);

// "error 0.021, 1.35 ms a frame, 5767440 bytes", of a variant of a report or of a neighbour.
std::string figuresText(const formats::Json& variant);

}  // namespace bakelight::pipeline
