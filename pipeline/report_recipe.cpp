#include "pipeline/report_recipe.h"

#include <algorithm>

#include "formats/error.h"

namespace bakelight::pipeline {
using formats::Json;
using formats::JsonReader;
namespace {

// Settings from { stage: { parameter: value } }.
std::vector<Setting> settingsOf(const Json& set, const std::string& origin) {
  std::vector<Setting> settings;
  for (const auto& [stage, parameters] : set.items())
    for (const auto& [parameter, value] : parameters.items()) {
      const std::string text = value.is_string() ? value.get<std::string>() : value.dump();
      settings.push_back({stage, parameter, text, origin});
    }
  return settings;
}

std::vector<Setting> settingsAt(const JsonReader& object, const char* key) {
  const JsonReader stages = object.object(key);
  for (const std::string& stage : stages.keys()) stages.object(stage);
  const ErrorPlace place = object.placeOf(key);
  return object.has(key) ? settingsOf(object.value(key), place.file + ", at " + place.pointer)
                         : std::vector<Setting>();
}

Wire wireAt(const JsonReader& object, const std::string& key) {
  const std::string& text = object.text(key);
  const std::size_t dot = text.find('.');
  return {text.substr(0, dot), dot == std::string::npos ? "" : text.substr(dot + 1)};
}

// What goes into a tool that compares variants, and what comes out of it.
constexpr const char* kPlanKind = "report_plan";
constexpr const char* kFiguresKind = "report";

std::string portOfKind(const std::vector<formats::PortDescription>& ports, const std::string& kind,
                       const ErrorPlace& place) {
  for (const formats::PortDescription& port : ports)
    if (port.kind == kind) return port.name;
  throw badInput(place, "this tool takes or gives no \"" + kind + "\"",
                 "a tool that compares variants, such as report");
}

bool makes(const Recipe& recipe, const Wire& wire) {
  const auto stage = recipe.stages.find(wire.stage);
  return stage != recipe.stages.end() && stage->second.outputs.count(wire.port) > 0;
}

}  // namespace

ReportRecipe::ReportRecipe(const Recipe& recipe, Problems& problems)
    : recipe_(recipe), object_(recipe.report, recipe.file, "/report") {
  if (recipe.report.empty())
    throw badInput({recipe.file, "", "/report"}, "the recipe does not say how its packs are measured",
                   "a section \"report\" (docs/REPORT.md)", "use a recipe that has one");
  problems.add(object_.unknownKeys(
      {"pack", "frame", "vary", "frame_parameters", "cameras", "reference", "comparison", "truth", "chain"}));
}

Wire ReportRecipe::pack() const {
  const Wire wire = wireAt(object_, "pack");
  if (!makes(recipe_, wire))
    throw badInput(object_.placeOf("pack"), "there is no output \"" + wire.text() + "\"",
                   "\"stage.output\" of this recipe");
  return wire;
}

std::string ReportRecipe::frameStage() const {
  return object_.text("frame", "");
}

std::vector<std::string> ReportRecipe::vary() const {
  return object_.texts("vary");
}

JsonReader ReportRecipe::cameras() const {
  return object_.object("cameras");
}

Json ReportRecipe::frameParameters() const {
  return object_.has("frame_parameters") ? object_.value("frame_parameters") : Json::object();
}

ReportRecipe::Reference ReportRecipe::reference(Problems& problems) const {
  const JsonReader object = object_.object("reference");
  problems.add(object.unknownKeys({"tool", "inputs", "outputs"}));
  Reference reference{object.text("tool"), inputsOf(object), "", ""};
  const JsonReader outputs = object.object("outputs");
  if (outputs.keys().size() != 1)
    throw badInput(object.placeOf("outputs"), "it has " + std::to_string(outputs.keys().size()) + " outputs",
                   "one, { \"image\": \"reference.exr\" }");
  reference.output = outputs.keys().front();
  reference.file = outputs.text(reference.output);
  return reference;
}

Comparison ReportRecipe::comparison(Toolbox& tools, Problems& problems) const {
  if (!object_.has("comparison"))
    throw badInput({recipe_.file, "", "/report"}, "the recipe does not say what compares its packs",
                   "\"comparison\": { \"tool\": …, \"outputs\": … } (docs/REPORT.md)",
                   R"(add "comparison": { "tool": "report", "outputs": { "report": "report.json" } })");
  const JsonReader object = object_.object("comparison");
  problems.add(object.unknownKeys({"tool", "outputs"}));
  Comparison comparison{object.text("tool"), "", "", {}};
  const formats::ToolDescription& tool = tools.require(comparison.tool, object.placeOf("tool")).description;
  comparison.plan_input = portOfKind(tool.inputs, kPlanKind, object.placeOf("tool"));
  comparison.figures_output = portOfKind(tool.outputs, kFiguresKind, object.placeOf("tool"));
  const JsonReader outputs = object.object("outputs");
  for (const std::string& port : outputs.keys()) {
    if (std::none_of(tool.outputs.begin(), tool.outputs.end(),
                     [&](const formats::PortDescription& output) { return output.name == port; }))
      throw badInput(outputs.placeOf(port), comparison.tool + " has no output \"" + port + "\"");
    comparison.files[port] = outputs.text(port);
  }
  if (comparison.files.count(comparison.figures_output) == 0)
    throw badInput(object.placeOf("outputs"), "the figures go nowhere",
                   "a file for \"" + comparison.figures_output + "\"");
  return comparison;
}

ReportRecipe::Link ReportRecipe::truth() const {
  return link(object_.object("truth"), kTruth);
}

std::vector<ReportRecipe::Link> ReportRecipe::chain(Problems& problems) const {
  std::vector<Link> links;
  for (const JsonReader& entry : object_.items("chain"))
    problems.attempt([&] {
      problems.add(entry.unknownKeys({"cause", "set", "reference", "inputs"}));
      links.push_back(link(entry, entry.text("cause")));
    });
  return links;
}

std::map<std::string, Wire> ReportRecipe::inputsOf(const JsonReader& object) const {
  std::map<std::string, Wire> wires;
  const JsonReader inputs = object.object("inputs");
  for (const std::string& port : inputs.keys()) {
    const Wire wire = wires[port] = wireAt(inputs, port);
    if (wire.stage != kView && wire.stage != kTruth && !makes(recipe_, wire) &&
        !(wire.fromAsset() && recipe_.asset.count(wire.port) > 0))
      throw badInput(inputs.placeOf(port), "there is no \"" + wire.text() + "\"",
                     "\"stage.output\" or \"asset.file\" of this recipe, \"view.environment\", "
                     "\"view.lights\" or \"truth.output\"");
  }
  return wires;
}

ReportRecipe::Link ReportRecipe::link(const JsonReader& object, const std::string& cause) const {
  Link link{cause, settingsAt(object, "set"), {}, inputsOf(object)};
  if (object.has("reference")) {
    object.object("reference");
    link.reference = object.value("reference");
  }
  return link;
}

}  // namespace bakelight::pipeline
