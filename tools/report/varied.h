// How the variants of a plan differ, for short names, colours and groups.
#pragma once

#include <string>
#include <vector>

#include "tools/report/plan.h"

namespace bakelight::report {

struct VariedParameter {
  std::string name;                   // "transfer.order"
  std::vector<std::string> values;    // that occur, in the order of the variants
  std::vector<std::size_t> value_of;  // of each variant: index into values; a missing one has the value "–"
  bool is_text = false;               // of any value
};

struct Varied {
  std::vector<VariedParameter> parameters;  // those with more than one value
  // The one that colours and shapes show: of those with texts the one with the most values, else the one with
  // the most values that there are colours for; parameters.size() if nothing varies.
  std::size_t shown = 0;

  bool hasShown() const { return shown < parameters.size(); }
};
// `most_values` is how many can be told apart.
Varied variedParameters(const Plan& plan, std::size_t most_values);

// Indices of those that labels name: all but the shown one and those that go with it.
std::vector<std::size_t> labelParameters(const Varied& varied);

// Their values of a variant, joined by " · ": "4 · 0.1". If there are none, the value of the shown one, else
// the variant's name.
std::string shortLabel(const Plan& plan, const Varied& varied, std::size_t variant);

// What a group of variants has in common and the others do not all have: "transfer.order=4"; "all" for all of
// them, and their names if they share nothing.
std::string groupText(const Plan& plan, const Varied& varied, const std::vector<std::size_t>& group);

}  // namespace bakelight::report
