#include "pipeline/budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <tuple>
#include <vector>

#include "formats/json_reader.h"
#include "pipeline/problems.h"

namespace bakelight::pipeline {
using formats::Json;
using formats::JsonReader;
namespace {

// One variant's figures.
struct Measured {
  std::string name;
  double error = 0, frame_ms = 0, bytes = 0;
};

std::vector<Measured> variantsIn(const Json& report) {
  std::vector<Measured> variants;
  for (const Json& variant : report.at("variants"))
    variants.push_back(
        {variant.at("name"), variant.at("rel_rmse"), variant.at("frame_ms"), variant.at("bytes")});
  return variants;
}

bool keeps(const Measured& variant, const Budget& budget) {
  return (!budget.error || variant.error <= *budget.error) &&
         (!budget.frame_ms || variant.frame_ms <= *budget.frame_ms) &&
         (!budget.bytes || variant.bytes <= *budget.bytes);
}

// How far beyond its limits, as the largest factor.
double excess(const Measured& variant, const Budget& budget) {
  double factor = 1;
  if (budget.error) factor = std::max(factor, variant.error / *budget.error);
  if (budget.frame_ms) factor = std::max(factor, variant.frame_ms / *budget.frame_ms);
  if (budget.bytes) factor = std::max(factor, variant.bytes / *budget.bytes);
  return factor;
}

Json toJson(const Measured& variant) {
  return {{"name", variant.name},
          {"rel_rmse", variant.error},
          {"frame_ms", variant.frame_ms},
          {"bytes", static_cast<std::uint64_t>(variant.bytes)}};
}

std::string figures(const Measured& variant) {
  return figuresText(toJson(variant));
}

class Chooser {
 public:
  Chooser(const Budget& budget, std::vector<Measured> variants)
      : budget_(budget), variants_(std::move(variants)), by_bytes_(budget.bytes && !budget.frame_ms) {}

  const Measured* chosen() const {
    const Measured* best = nullptr;
    for (const Measured& variant : variants_)
      if (keeps(variant, budget_) && (best == nullptr || rank(variant) < rank(*best))) best = &variant;
    return best;
  }

  const Measured* nearest() const {
    const auto found = std::min_element(
        variants_.begin(), variants_.end(),
        [&](const Measured& a, const Measured& b) { return excess(a, budget_) < excess(b, budget_); });
    return found == variants_.end() ? nullptr : &*found;
  }

  // The cheapest that errs less, and the most exact that costs less.
  Json nextBetter(const Measured& than) const {
    return neighbor([&](const Measured& variant) { return variant.error < than.error; },
                    [&](const Measured& variant) { return std::tuple(cost(variant), variant.error); });
  }
  Json nextCheaper(const Measured& than) const {
    return neighbor([&](const Measured& variant) { return cost(variant) < cost(than); },
                    [&](const Measured& variant) { return std::tuple(variant.error, cost(variant)); });
  }

  std::string why(const Measured& chosen) const {
    const auto count = std::count_if(variants_.begin(), variants_.end(),
                                     [&](const Measured& variant) { return keeps(variant, budget_); });
    const char* cheapest = by_bytes_ ? "the smallest" : "the fastest";
    return std::string(budget_.error ? cheapest : "the most exact") + " of " + std::to_string(count) +
           " variants within the budget, of " + std::to_string(variants_.size()) +
           " measured: " + figures(chosen);
  }

 private:
  double cost(const Measured& variant) const { return by_bytes_ ? variant.bytes : variant.frame_ms; }

  std::tuple<double, double, std::string> rank(const Measured& variant) const {
    return {budget_.error ? cost(variant) : variant.error, variant.bytes, variant.name};
  }

  template <class Condition, class Rank>
  Json neighbor(const Condition& condition, const Rank& rank_of) const {
    const Measured* best = nullptr;
    for (const Measured& variant : variants_)
      if (condition(variant) && (best == nullptr || rank_of(variant) < rank_of(*best))) best = &variant;
    return best == nullptr ? Json() : toJson(*best);
  }

  const Budget& budget_;
  const std::vector<Measured> variants_;
  const bool by_bytes_;
};

Json limitsOf(const Budget& budget) {
  Json limits = Json::object();
  if (budget.error) limits["error"] = *budget.error;
  if (budget.frame_ms) limits["frame_ms"] = *budget.frame_ms;
  if (budget.bytes) limits["bytes"] = *budget.bytes;
  return limits;
}

}  // namespace

std::string figuresText(const Json& variant) {
  return fmt::format("error {:.3g}, {:.3g} ms a frame, {:.0f} bytes", variant.at("rel_rmse").get<double>(),
                     variant.at("frame_ms").get<double>(), variant.at("bytes").get<double>());
}

Budget parseBudget(const Json& json, const ErrorPlace& place) {
  Problems problems;
  const JsonReader object(json, place.file, place.pointer);
  problems.add(object.unknownKeys({"error", "frame_ms", "bytes"}));
  problems.throwIfAny();
  const auto limit = [&](const char* key) -> std::optional<double> {
    if (!object.has(key)) return {};
    if (!object.value(key).is_number() || object.value(key).get<double>() <= 0)
      throw badInput(object.placeOf(key), object.value(key).dump() + " is no limit", "a number above 0");
    return object.value(key).get<double>();
  };
  const Budget budget{limit("error"), limit("frame_ms"), limit("bytes")};
  if (!budget.error && !budget.frame_ms && !budget.bytes)
    throw badInput(place, "the budget limits nothing", "\"error\", \"frame_ms\" or \"bytes\"");
  return budget;
}

Json chooseVariant(const Budget& budget, const Json& report, const ErrorPlace& place) {
  const Chooser chooser(budget, variantsIn(report));
  const Measured* chosen = chooser.chosen();
  if (chosen == nullptr) {
    const Measured* nearest = chooser.nearest();
    throw badInput(place, "no variant keeps the budget",
                   nearest == nullptr ? "" : "the nearest is " + nearest->name + ": " + figures(*nearest),
                   "allow more, or vary more parameters in \"report\", \"vary\"");
  }
  Json choice = toJson(*chosen);
  choice["chosen"] = chosen->name;
  choice.erase("name");
  for (const Json& variant : report.at("variants"))
    if (variant.at("name") == chosen->name) choice["parameters"] = variant.at("parameters");
  choice["limits"] = limitsOf(budget);
  choice["why"] = chooser.why(*chosen);
  choice["next_better"] = chooser.nextBetter(*chosen);
  choice["next_cheaper"] = chooser.nextCheaper(*chosen);
  return choice;
}

}  // namespace bakelight::pipeline
