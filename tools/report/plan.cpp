#include "tools/report/plan.h"

#include <nlohmann/json.hpp>
#include <set>

#include "formats/json_reader.h"

namespace bakelight::report {
namespace {

using formats::JsonReader;

constexpr JsonReader::Range kAtLeastZero = {.minimum = 0};

// Each of `required` must be there; nothing but those and `optional` may be.
void requireKeys(const JsonReader& object, const std::vector<std::string>& required,
                 const std::vector<std::string>& optional = {}) {
  for (const std::string& key : required) object.at(key);
  std::vector<std::string> known = required;
  known.insert(known.end(), optional.begin(), optional.end());
  object.allowKeys(known);
}

// Nothing for null, too.
std::optional<JsonReader> given(const JsonReader& object, const std::string& key) {
  std::optional<JsonReader> member = object.find(key);
  return member && member->value().is_null() ? std::nullopt : member;
}

// fileOf and the like take an element that must be there; what may be null goes through given.
PlanFile fileOf(const JsonReader& element) {
  requireKeys(element, {"path", "hash"});
  return {element.text("path"), element.text("hash")};
}

std::filesystem::path pathOf(const std::optional<JsonReader>& element) {
  return element ? fileOf(*element).path : std::filesystem::path();
}

// In place of a number.
constexpr const char* kMeasured = "measured";

PlanView viewOf(const JsonReader& element) {
  requireKeys(element, {"name", "light", "camera", "frame", "reference"},
              {"environment", "lights", "windowing"});
  PlanView view;
  view.name = element.text("name");
  view.light = element.text("light");
  view.camera = element.text("camera");
  view.environment_path = pathOf(given(element, "environment"));
  view.lights_path = pathOf(given(element, "lights"));
  if (const auto windowing = given(element, "windowing")) {
    view.windows_measured = windowing->value() == kMeasured;
    view.windowing = view.windows_measured ? 0 : windowing->number();
  }
  const JsonReader frame = element.at("frame");
  view.frame = formats::frameSettingsFromJson(frame.value(), frame.file(), frame.pointer());
  view.frame.background = formats::Background::kTransparent;
  view.reference = fileOf(element.at("reference"));
  return view;
}

StageFigures stageOf(const JsonReader& element) {
  requireKeys(element, {"stage", "wall_s", "cpu_s", "peak_memory_bytes", "bytes"}, {"warnings"});
  StageFigures stage;
  stage.stage = element.text("stage");
  stage.wall_s = element.number("wall_s", kAtLeastZero);
  stage.cpu_s = element.number("cpu_s", kAtLeastZero);
  stage.peak_memory_bytes = static_cast<std::uint64_t>(element.number("peak_memory_bytes", kAtLeastZero));
  stage.bytes = static_cast<std::uint64_t>(element.number("bytes", kAtLeastZero));
  if (const auto warnings = given(element, "warnings"))
    for (const JsonReader& warning : warnings->items()) stage.warnings.push_back(warning.text());
  return stage;
}

LeftOut leftOutOf(const JsonReader& element) {
  requireKeys(element, {"stage", "what", "figure", "value", "threshold"}, {"error"});
  LeftOut left_out{element.text("stage"),   element.text("what"),        element.text("figure"),
                   element.number("value"), element.number("threshold"), std::nullopt};
  if (const auto error = given(element, "error")) left_out.error = error->number();
  return left_out;
}

ChainLink linkOf(const JsonReader& element, std::size_t view_count) {
  requireKeys(element, {"cause"}, {"references", "pack"});
  ChainLink link;
  link.cause = element.text("cause");
  const auto references = given(element, "references"), pack = given(element, "pack");
  if (references.has_value() == pack.has_value())
    throw element.error("it is not clear which pictures it has", "either references or pack");
  if (pack) link.pack = fileOf(*pack);
  if (!references) return link;
  for (const JsonReader& reference : references->items()) link.references.push_back(fileOf(reference));
  if (link.references.size() != view_count)
    throw references->error("it has " + std::to_string(link.references.size()) + " files",
                            "one a view, " + std::to_string(view_count));
  return link;
}

// NAME, NAME_low and NAME_high; without the quartiles the median stands for them.
std::optional<Spread> glSpreadIn(const JsonReader& player, const std::string& name) {
  const std::optional<JsonReader> median = given(player, name), low = given(player, name + "_low"),
                                  high = given(player, name + "_high");
  if (!median) return std::nullopt;
  const double value = median->number(kAtLeastZero);
  return Spread{value, low ? low->number(kAtLeastZero) : value, high ? high->number(kAtLeastZero) : value};
}

Spread glSpreadOf(const JsonReader& player, const std::string& name) {
  const std::optional<Spread> spread = glSpreadIn(player, name);
  if (!spread) throw player.error("it has no " + name, "the player's stats, or null");
  return *spread;
}

// The player's stats have more than this.
GlTimes glTimesOf(const JsonReader& player) {
  if (!player.value().is_object()) throw player.error("it is not an object", "the player's stats, or null");
  return {glSpreadOf(player, "light_change_ms"), glSpreadOf(player, "frame_ms"),
          glSpreadIn(player, "gpu_light_change_ms"), glSpreadIn(player, "gpu_frame_ms")};
}

PlanVariant variantOf(const JsonReader& element, std::size_t view_count) {
  requireKeys(element, {"name", "parameters", "pack"}, {"stages", "left_out", "player", "chain"});
  PlanVariant variant;
  variant.name = element.text("name");
  variant.parameters = element.at("parameters").value();
  if (!variant.parameters.is_object())
    throw element.at("parameters").error("it is not an object", "an object");
  variant.pack = fileOf(element.at("pack"));
  if (const auto stages = given(element, "stages"))
    for (const JsonReader& stage : stages->items()) variant.stages.push_back(stageOf(stage));
  if (const auto left_out = given(element, "left_out"))
    for (const JsonReader& item : left_out->items()) variant.left_out.push_back(leftOutOf(item));
  if (const auto player = given(element, "player")) variant.gl = glTimesOf(*player);
  if (const auto chain = given(element, "chain"))
    for (const JsonReader& link : chain->items()) variant.chain.push_back(linkOf(link, view_count));
  return variant;
}

template <class Items>
void requireDifferentNames(const Items& items, const JsonReader& list) {
  std::set<std::string> names;
  for (const auto& item : items)
    if (!names.insert(item.name).second)
      throw list.error("\"" + item.name + "\" is there twice", "names that differ");
}

}  // namespace

Plan planFromJson(const formats::Json& json, const std::string& file) {
  const JsonReader root(json, file);
  requireKeys(root, {"asset", "views", "variants"}, {"failed"});
  Plan plan;
  plan.asset = root.text("asset");
  for (const JsonReader& view : root.items("views")) plan.views.push_back(viewOf(view));
  if (plan.views.empty()) throw root.at("views").error("there is no view", "at least one");
  requireDifferentNames(plan.views, root.at("views"));
  for (const PlanView& view : plan.views)
    if (view.windows_measured != plan.views.front().windows_measured)
      throw root.at("views").error("\"windowing\" is measured in some views, and not in others",
                                   "\"measured\" in all views, or in none");
  for (const JsonReader& variant : root.items("variants"))
    plan.variants.push_back(variantOf(variant, plan.views.size()));
  if (plan.variants.empty()) throw root.at("variants").error("there is no variant", "at least one");
  requireDifferentNames(plan.variants, root.at("variants"));
  if (const auto failed = given(root, "failed"))
    for (const JsonReader& item : failed->items()) {
      requireKeys(item, {"name", "stage", "reason"});
      plan.failed.push_back({item.text("name"), item.text("stage"), item.text("reason")});
    }
  return plan;
}

}  // namespace bakelight::report
