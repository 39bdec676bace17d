#include "tools/report/plan.h"

#include <nlohmann/json.hpp>
#include <set>

#include "tools/report/json_element.h"

namespace bakelight::report {
namespace {

// fileOf and the like take an element that must be there; what may be null goes through JsonElement::find.
PlanFile fileOf(const JsonElement& element) {
  element.requireKeys({"path", "hash"});
  return {element.at("path").text(), element.at("hash").text()};
}

std::filesystem::path pathOf(const std::optional<JsonElement>& element) {
  return element ? fileOf(*element).path : std::filesystem::path();
}

PlanView viewOf(const JsonElement& element) {
  element.requireKeys({"name", "light", "camera", "frame", "reference"},
                      {"environment", "lights", "windowing"});
  PlanView view;
  view.name = element.at("name").text();
  view.light = element.at("light").text();
  view.camera = element.at("camera").text();
  view.environment_path = pathOf(element.find("environment"));
  view.lights_path = pathOf(element.find("lights"));
  if (const auto windowing = element.find("windowing")) view.windowing = windowing->number();
  const JsonElement frame = element.at("frame");
  view.frame = formats::frameSettingsFromJson(frame.value(), frame.file(), frame.pointer());
  view.frame.background = formats::Background::kTransparent;
  view.reference = fileOf(element.at("reference"));
  return view;
}

StageFigures stageOf(const JsonElement& element) {
  element.requireKeys({"stage", "wall_s", "cpu_s", "peak_memory_bytes", "bytes"}, {"warnings"});
  StageFigures stage;
  stage.stage = element.at("stage").text();
  stage.wall_s = element.at("wall_s").atLeastZero();
  stage.cpu_s = element.at("cpu_s").atLeastZero();
  stage.peak_memory_bytes = static_cast<std::uint64_t>(element.at("peak_memory_bytes").atLeastZero());
  stage.bytes = static_cast<std::uint64_t>(element.at("bytes").atLeastZero());
  if (const auto warnings = element.find("warnings"))
    for (const JsonElement& warning : warnings->items()) stage.warnings.push_back(warning.text());
  return stage;
}

LeftOut leftOutOf(const JsonElement& element) {
  element.requireKeys({"stage", "what", "figure", "value", "threshold"}, {"error"});
  LeftOut left_out{element.at("stage").text(),       element.at("what").text(),
                   element.at("figure").text(),      element.at("value").number(),
                   element.at("threshold").number(), std::nullopt};
  if (const auto error = element.find("error")) left_out.error = error->number();
  return left_out;
}

ChainLink linkOf(const JsonElement& element, std::size_t view_count) {
  element.requireKeys({"cause"}, {"references", "pack"});
  ChainLink link;
  link.cause = element.at("cause").text();
  const auto references = element.find("references"), pack = element.find("pack");
  if (references.has_value() == pack.has_value())
    throw element.error("it is not clear which pictures it has", "either references or pack");
  if (pack) link.pack = fileOf(*pack);
  if (!references) return link;
  for (const JsonElement& reference : references->items()) link.references.push_back(fileOf(reference));
  if (link.references.size() != view_count)
    throw references->error("it has " + std::to_string(link.references.size()) + " files",
                            "one a view, " + std::to_string(view_count));
  return link;
}

// NAME, NAME_low and NAME_high; without the quartiles the median stands for them.
std::optional<Spread> glSpreadIn(const JsonElement& player, const std::string& name) {
  const std::optional<JsonElement> median = player.find(name), low = player.find(name + "_low"),
                                   high = player.find(name + "_high");
  if (!median) return std::nullopt;
  const double value = median->atLeastZero();
  return Spread{value, low ? low->atLeastZero() : value, high ? high->atLeastZero() : value};
}

Spread glSpreadOf(const JsonElement& player, const std::string& name) {
  const std::optional<Spread> spread = glSpreadIn(player, name);
  if (!spread) throw player.error("it has no " + name, "the player's stats, or null");
  return *spread;
}

// The player's stats have more than this.
GlTimes glTimesOf(const JsonElement& player) {
  if (!player.value().is_object()) throw player.error("it is not an object", "the player's stats, or null");
  return {glSpreadOf(player, "light_change_ms"), glSpreadOf(player, "frame_ms"),
          glSpreadIn(player, "gpu_light_change_ms"), glSpreadIn(player, "gpu_frame_ms")};
}

PlanVariant variantOf(const JsonElement& element, std::size_t view_count) {
  element.requireKeys({"name", "parameters", "pack"}, {"stages", "left_out", "player", "chain"});
  PlanVariant variant;
  variant.name = element.at("name").text();
  variant.parameters = element.at("parameters").value();
  if (!variant.parameters.is_object())
    throw element.at("parameters").error("it is not an object", "an object");
  variant.pack = fileOf(element.at("pack"));
  if (const auto stages = element.find("stages"))
    for (const JsonElement& stage : stages->items()) variant.stages.push_back(stageOf(stage));
  if (const auto left_out = element.find("left_out"))
    for (const JsonElement& item : left_out->items()) variant.left_out.push_back(leftOutOf(item));
  if (const auto player = element.find("player")) variant.gl = glTimesOf(*player);
  if (const auto chain = element.find("chain"))
    for (const JsonElement& link : chain->items()) variant.chain.push_back(linkOf(link, view_count));
  return variant;
}

template <class Items>
void requireDifferentNames(const Items& items, const JsonElement& list) {
  std::set<std::string> names;
  for (const auto& item : items)
    if (!names.insert(item.name).second)
      throw list.error("\"" + item.name + "\" is there twice", "names that differ");
}

}  // namespace

Plan planFromJson(const formats::Json& json, const std::string& file) {
  const JsonElement root(json, file);
  root.requireKeys({"asset", "views", "variants"}, {"failed"});
  Plan plan;
  plan.asset = root.at("asset").text();
  for (const JsonElement& view : root.at("views").items()) plan.views.push_back(viewOf(view));
  if (plan.views.empty()) throw root.at("views").error("there is no view", "at least one");
  requireDifferentNames(plan.views, root.at("views"));
  for (const JsonElement& variant : root.at("variants").items())
    plan.variants.push_back(variantOf(variant, plan.views.size()));
  if (plan.variants.empty()) throw root.at("variants").error("there is no variant", "at least one");
  requireDifferentNames(plan.variants, root.at("variants"));
  if (const auto failed = root.find("failed"))
    for (const JsonElement& item : failed->items()) {
      item.requireKeys({"name", "stage", "reason"});
      plan.failed.push_back({item.at("name").text(), item.at("stage").text(), item.at("reason").text()});
    }
  return plan;
}

}  // namespace bakelight::report
