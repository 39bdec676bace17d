// Variants of an asset: what a sweep varies, as people write it.
#pragma once

#include <string>
#include <vector>

#include "formats/json.h"
#include "pipeline/asset.h"

namespace bakelight::pipeline {

// One combination of values.
struct Variant {
  std::string name;               // "order=4,storage=cpca"; a folder's name, too
  std::vector<Setting> settings;  // what makes it
};

// Each text is "STAGE.PARAMETER=CHOICE,CHOICE,...": a choice is a value, or a range of integers a..b, and may
// bring further settings along: "transfer.storage=cpca,visibility+transfer.transport=shadowed". Returns all
// combinations, the last text's values running fastest; one without settings, "base", if there is no text.
// Throws Error(kUsage) for what is none of that, for a parameter that is varied twice, and for more than
// kMostVariants.
inline constexpr std::size_t kMostVariants = 1000;
std::vector<Variant> variantsOf(const std::vector<std::string>& vary);

// By "stage.parameter"; numbers and lists as such.
formats::Json parametersOf(const Variant& variant);

}  // namespace bakelight::pipeline
