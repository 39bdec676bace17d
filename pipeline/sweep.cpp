#include "pipeline/sweep.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/error.h"
#include "formats/file.h"
#include "pipeline/json_object.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
namespace {

constexpr const char* kReferenceTool = "reference";
constexpr const char* kReferenceFile = "reference.exr";

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

// The recipe's section "report", checked as far as the driver reads it.
class ReportRecipe {
 public:
  ReportRecipe(const Recipe& recipe, Problems& problems)
      : recipe_(recipe), object_(recipe.report, recipe.file, "/report") {
    if (recipe.report.empty())
      throw badInput({recipe.file, "", "/report"}, "the recipe does not say how its packs are measured",
                     "a section \"report\" (docs/REPORT.md)", "use a recipe that has one");
    object_.allowKeys(
        {"pack", "frame", "vary", "frame_parameters", "cameras", "same_scene", "scene", "truth", "chain"},
        problems);
  }

  struct Link {
    std::string cause;
    std::vector<Setting> settings;
    std::optional<Json> reference;  // parameters; values may be { "same_as": "stage.parameter" }
  };

  Wire pack() const {
    const std::string text = object_.text("pack");
    const std::size_t dot = text.find('.');
    const Wire wire{text.substr(0, dot), dot == std::string::npos ? "" : text.substr(dot + 1)};
    const auto stage = recipe_.stages.find(wire.stage);
    if (stage == recipe_.stages.end() || stage->second.outputs.count(wire.port) == 0)
      throw badInput(object_.placeOf("pack"), "there is no output \"" + text + "\"",
                     "\"stage.output\" of this recipe");
    return wire;
  }
  std::string frameStage() const { return object_.text("frame", ""); }
  std::vector<std::string> vary() const { return object_.texts("vary"); }
  JsonObject cameras() const { return object_.object("cameras"); }
  Json frameParameters() const { return valueOr("frame_parameters", Json::object()); }
  std::vector<std::string> sameScene() const { return object_.texts("same_scene"); }
  std::vector<Setting> sceneSettings() const { return settingsAt(object_, "scene"); }
  Link truth() const { return link(object_.object("truth"), "truth"); }

  std::vector<Link> chain(Problems& problems) const {
    std::vector<Link> links;
    const Json list = valueOr("chain", Json::array());
    if (!list.is_array()) throw badInput(object_.placeOf("chain"), "is no list", "a list of links");
    for (std::size_t i = 0; i < list.size(); ++i)
      problems.attempt([&] {
        const JsonObject entry(list[i], recipe_.file, "/report/chain/" + std::to_string(i));
        entry.allowKeys({"cause", "set", "reference"}, problems);
        links.push_back(link(entry, entry.text("cause")));
      });
    return links;
  }

 private:
  Json valueOr(const char* key, const Json& otherwise) const {
    return object_.has(key) ? object_.value(key) : otherwise;
  }

  static std::vector<Setting> settingsAt(const JsonObject& object, const char* key) {
    const JsonObject stages = object.object(key);
    for (const std::string& stage : stages.keys()) stages.object(stage);
    const ErrorPlace place = object.placeOf(key);
    return object.has(key) ? settingsOf(object.value(key), place.file + ", at " + place.pointer)
                           : std::vector<Setting>();
  }

  static Link link(const JsonObject& object, const std::string& cause) {
    Link link{.cause = cause, .settings = settingsAt(object, "set"), .reference = {}};
    if (object.has("reference")) {
      object.object("reference");
      link.reference = object.value("reference");
    }
    return link;
  }

  const Recipe& recipe_;
  JsonObject object_;
};

std::string fileName(std::string name) {
  for (char& c : name)
    if (c == '/' || c == ' ') c = '-';
  return name;
}

class Planner {
 public:
  Planner(const Asset& asset, const Recipe& recipe, RecipeBook& recipes, Toolbox& tools,
          const SweepOptions& options, Problems& problems)
      : base_(asset),
        recipe_(recipe),
        recipes_(recipes),
        tools_(tools),
        options_(options),
        problems_(problems),
        how_(recipe, problems) {}

  Sweep plan() {
    pack_ = how_.pack();
    sweep_.pack_output = pack_.port;
    planVariants();
    problems_.throwIfAny();
    makeSweepGraph();
    problems_.throwIfAny();
    planViews();
    for (const View& view : sweep_.views)
      sweep_.truths.push_back(referenceTask(truth_, how_.truth(), view, {}, truth_));
    for (std::size_t i = 0; i < sweep_.variants.size(); ++i) addPictures(i);
    problems_.throwIfAny();
    return std::move(sweep_);
  }

 private:
  // Places in `wanted_` of the assets of a variant.
  struct Wanted {
    std::size_t variant = 0;
    std::vector<std::size_t> links;  // by link of the chain
  };

  std::vector<std::string> vary() const {
    if (!options_.vary.empty()) return options_.vary;
    const JsonObject own(base_.report, base_.file, "/report");
    return own.has("vary") ? own.texts("vary") : how_.vary();
  }

  std::size_t want(const std::string& name, std::vector<Setting> settings, bool with_frame, bool keep_all) {
    Asset asset = base_;
    asset.name = name;
    asset.label = base_.name;
    asset.settings = options_.settings;
    asset.settings.insert(asset.settings.end(), settings.begin(), settings.end());
    asset.keep_all = asset.keep_all || keep_all;
    asset.budget = asset.choice = {};
    std::vector<std::string> deliver;
    for (const auto& [deliverable, wire] : recipe_.deliverables)
      if (wire.text() == pack_.text() || (with_frame && wire.stage == how_.frameStage()))
        deliver.push_back(deliverable);
    asset.deliver = deliver;
    wanted_.push_back(std::move(asset));
    return wanted_.size() - 1;
  }

  void planVariants() {
    const std::vector<Variant> variants = variantsOf(vary());
    chain_ = how_.chain(problems_);
    scene_ = how_.sceneSettings();
    truth_wanted_ = want("truth", joined(scene_, how_.truth().settings), false, true);
    for (const Variant& variant : variants) {
      checkSameScene(variant);
      Wanted wanted{want(variant.name, variant.settings, true, false), {}};
      for (const ReportRecipe::Link& link : chain_) {
        std::vector<Setting> settings = variant.settings;
        if (link.reference) settings = joined(settings, scene_);
        wanted.links.push_back(
            want(variant.name + " (" + link.cause + ")", joined(settings, link.settings), false, true));
      }
      of_variant_.push_back(std::move(wanted));
      sweep_.variants.push_back({.variant = variant, .pack = 0, .frame = {}, .chain = {}});
    }
  }

  static std::vector<Setting> joined(std::vector<Setting> first, const std::vector<Setting>& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  }

  void checkSameScene(const Variant& variant) {
    for (const Setting& setting : variant.settings)
      for (const std::string& fixed : how_.sameScene())
        if (setting.stage + "." + setting.parameter == fixed)
          problems_.add(
              Error(ExitStatus::kUsage, {setting.option, "", ""}, fixed + " changes the scene itself",
                    "variants of one scene, whose pictures can be compared", "make an asset of each"));
  }

  // Assets of equal tasks become one: what differs only in what a scene pack does not hold is baked once.
  void makeSweepGraph() {
    const Graph all = makeGraph(wanted_, recipes_, tools_, {}, problems_);
    problems_.throwIfAny();
    std::map<std::string, std::size_t> kept_of;
    std::vector<Asset> kept;
    for (std::size_t asset = 0; asset < wanted_.size(); ++asset) {
      const auto [place, is_new] = kept_of.emplace(signature(all, asset), kept.size());
      if (is_new) kept.push_back(wanted_[asset]);
      kept_.push_back(place->second);
    }
    sweep_.graph = makeGraph(std::move(kept), recipes_, tools_, {}, problems_);
    for (TaskIndex task = 0; task < sweep_.graph.tasks.size(); ++task) {
      Task& made = sweep_.graph.tasks[task];
      tasks_[{made.asset, made.stage}] = task;
      made.published = !made.deliverables.empty() && isVariant(made.asset);
    }
    truth_ = kept_[truth_wanted_];
  }

  bool isVariant(std::size_t kept) const {
    for (const Wanted& wanted : of_variant_)
      if (kept_[wanted.variant] == kept) return true;
    return false;
  }

  static std::string signature(const Graph& graph, std::size_t asset) {
    Json tasks = Json::array();
    for (const Task& task : graph.tasks)
      if (task.asset == asset)
        tasks.push_back({task.stage, task.parameters, task.left_out, task.rules.size(), task.deliverables});
    return tasks.dump();
  }

  void planViews() {
    std::map<std::string, fs::path> lights = base_.report_lights;
    const bool own_light = lights.empty();
    if (own_light) lights["light"] = fs::path();
    const JsonObject own(base_.report, base_.file, "/report");
    const JsonObject cameras = own.has("cameras") ? own.object("cameras") : how_.cameras();
    const double windowing = playersWindowing();
    for (const auto& [light, path] : lights)
      for (const std::string& camera : cameras.keys()) {
        View view{.name = fileName(light + "-" + camera), .light = light, .camera = camera};
        const bool rig = formats::lowerEnding(path) == ".json";
        const auto asked = [&](const char* port) {
          const auto file = base_.files.find(port);
          return own_light && file != base_.files.end() ? file->second : fs::path();
        };
        view.environment = own_light ? asked("environment") : rig ? fs::path() : path;
        view.lights = own_light ? asked("lights") : rig ? path : fs::path();
        view.windowing = windowing;
        view.frame = how_.frameParameters();
        cameras.object(camera);
        view.frame.update(cameras.value(camera));
        sweep_.views.push_back(std::move(view));
      }
    if (sweep_.views.empty())
      problems_.add(
          badInput({recipe_.file, "", "/report/cameras"}, "there is no camera", "one camera or more"));
  }

  double playersWindowing() const {
    const auto frame = tasks_.find({kept_[of_variant_.front().variant], how_.frameStage()});
    if (frame == tasks_.end()) return 0;
    return sweep_.graph.tasks[frame->second].parameters.value("windowing", 0.0);
  }

  // Of { "same_as": "stage.parameter" }: the parameter's value in the asset `values_of`.
  Json linkedValue(const Json& value, const std::string& element, std::size_t values_of) const {
    const std::string from = value.contains("same_as") && value["same_as"].is_string()
                                 ? value["same_as"].get<std::string>()
                                 : std::string();
    const std::size_t dot = std::min(from.find('.'), from.size());
    const auto task = tasks_.find({values_of, from.substr(0, dot)});
    const std::string parameter = from.substr(std::min(dot + 1, from.size()));
    if (task == tasks_.end() || !sweep_.graph.tasks[task->second].parameters.contains(parameter))
      throw badInput({recipe_.file, element, "/report"}, "there is no parameter \"" + from + "\"",
                     "{ \"same_as\": \"stage.parameter\" }, of a stage of this recipe");
    return sweep_.graph.tasks[task->second].parameters.at(parameter);
  }

  Json referenceParameters(const ReportRecipe::Link& link, const View& view, std::size_t values_of) {
    Json given = view.frame;
    for (const auto& [name, value] : link.reference->items()) {
      if (!value.is_object()) {
        given[name] = value;
        continue;
      }
      given[name] = linkedValue(value, link.cause + ", " + name, values_of);
    }
    const InstalledTool& tool = tools_.require(kReferenceTool, {recipe_.file, "", "/report"});
    Json parameters = defaultParameters(tool.description);
    parameters.update(formats::checkParameters(tool.description, given, {recipe_.file, "", "/report/chain"}));
    return parameters;
  }

  // A path-traced picture of the pack of the asset `scene`; `link`'s parameters that are "same_as" another
  // are those of `values_of`. Its camera is that of the reference `truth`, as another mesh would be framed
  // otherwise; without one, `scene` is the truth.
  TaskIndex referenceTask(std::size_t scene, const ReportRecipe::Link& link, const View& view,
                          std::optional<TaskIndex> truth, std::size_t values_of) {
    Task task{.asset = scene, .stage = view.name, .tool = kReferenceTool};
    task.inputs["pack"] = {.maker = tasks_.at({scene, pack_.stage}), .port = pack_.port};
    if (!view.environment.empty())
      task.inputs["environment"] = {.port = "environment", .file = view.environment};
    if (!view.lights.empty()) task.inputs["lights"] = {.port = "lights", .file = view.lights};
    if (truth) task.inputs["framing"] = {.maker = truth, .port = "image"};
    task.outputs["image"] = kReferenceFile;
    task.parameters = referenceParameters(link, view, values_of);
    task.published = !truth;
    const std::string key =
        std::to_string(scene) + view.name + (truth ? "" : " truth") + task.parameters.dump();
    const auto [known, is_new] = references_.emplace(key, sweep_.graph.tasks.size());
    if (is_new) {
      if (truth) task.stage = unusedStageName(scene, view.name + " (" + link.cause + ")");
      sweep_.graph.tasks.push_back(std::move(task));
    }
    return known->second;
  }

  // Links of several variants may be traced on one pack.
  std::string unusedStageName(std::size_t asset, const std::string& name) const {
    const auto taken = [&](const std::string& candidate) {
      return std::any_of(sweep_.graph.tasks.begin(), sweep_.graph.tasks.end(),
                         [&](const Task& task) { return task.asset == asset && task.stage == candidate; });
    };
    std::string candidate = name;
    for (int i = 2; taken(candidate); ++i) candidate = name + " " + std::to_string(i);
    return candidate;
  }

  void addPictures(std::size_t index) {
    SweptVariant& swept = sweep_.variants[index];
    const Wanted& wanted = of_variant_[index];
    const std::size_t own = kept_[wanted.variant];
    swept.pack = tasks_.at({own, pack_.stage});
    const auto frame = tasks_.find({own, how_.frameStage()});
    if (frame != tasks_.end()) {
      swept.frame = frame->second;
      sweep_.graph.tasks[frame->second].parameters.update(playersFrame(frame->second));
    }
    // The variant's own values count, also where the pack that is traced has others.
    const std::size_t values_of = wanted.links.empty() ? own : kept_[wanted.links.back()];
    for (std::size_t i = 0; i < chain_.size(); ++i) {
      Link link{.cause = chain_[i].cause, .references = {}};
      const std::size_t asset = kept_[wanted.links[i]];
      if (chain_[i].reference)
        for (std::size_t view = 0; view < sweep_.views.size(); ++view)
          link.references.push_back(
              referenceTask(asset, chain_[i], sweep_.views[view], sweep_.truths[view], values_of));
      else
        link.pack = tasks_.at({asset, pack_.stage});
      swept.chain.push_back(std::move(link));
    }
  }

  // The player draws the first view, so that times are of the same picture for all.
  Json playersFrame(TaskIndex frame) {
    const std::string& name = sweep_.graph.tasks[frame].tool;
    Json known = Json::object();
    for (const auto& [parameter, value] : sweep_.views.front().frame.items())
      if (tools_.require(name, {}).description.findParameter(parameter) != nullptr) known[parameter] = value;
    return formats::checkParameters(tools_.require(name, {}).description, known,
                                    {recipe_.file, "", "/report/frame_parameters"});
  }

  const Asset& base_;
  const Recipe& recipe_;
  RecipeBook& recipes_;
  Toolbox& tools_;
  const SweepOptions& options_;
  Problems& problems_;
  const ReportRecipe how_;

  Wire pack_;
  std::vector<ReportRecipe::Link> chain_;
  std::vector<Setting> scene_;
  std::vector<Asset> wanted_;
  std::vector<std::size_t> kept_;  // by wanted: place in the graph's assets
  std::size_t truth_wanted_ = 0, truth_ = 0;
  std::vector<Wanted> of_variant_;
  std::map<std::pair<std::size_t, std::string>, TaskIndex> tasks_;  // by asset and stage
  std::map<std::string, TaskIndex> references_;
  Sweep sweep_;
};

}  // namespace

Sweep planSweep(const Asset& asset, RecipeBook& recipes, Toolbox& tools, const SweepOptions& options,
                Problems& problems) {
  const Recipe& recipe = recipes.require(asset.recipe, {asset.file, "", "/recipe"});
  return Planner(asset, recipe, recipes, tools, options, problems).plan();
}

}  // namespace bakelight::pipeline
