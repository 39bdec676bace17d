#include "pipeline/sweep.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json_reader.h"
#include "pipeline/report_recipe.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
using formats::JsonReader;
namespace {

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
    reference_ = how_.reference(problems_);
    sweep_.reference_output = reference_.output;
    sweep_.comparison = how_.comparison(tools_, problems_);
    planVariants();
    problems_.throwIfAny();
    makeSweepGraph();
    problems_.throwIfAny();
    planViews();
    for (const View& view : sweep_.views)
      sweep_.truths.push_back(referenceTask(kept_[truth_wanted_], truth_, view, {}, kept_[truth_wanted_]));
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
    const JsonReader own(base_.report, base_.file, "/report");
    return own.has("vary") ? own.texts("vary") : how_.vary();
  }

  // The asset with other settings, of which nothing is wanted yet.
  Asset assetFor(const std::string& name, const std::vector<Setting>& settings) const {
    Asset asset = base_;
    asset.name = name;
    asset.label = base_.name;
    asset.settings = options_.settings;
    asset.settings.insert(asset.settings.end(), settings.begin(), settings.end());
    asset.budget = asset.choice = {};
    asset.deliver.emplace();
    return asset;
  }

  std::size_t want(Asset asset) {
    wanted_.push_back(std::move(asset));
    return wanted_.size() - 1;
  }

  std::size_t wantPack(Asset asset, bool with_frame) {
    for (const auto& [deliverable, wire] : recipe_.deliverables)
      if (wire.text() == pack_.text() || (with_frame && wire.stage == how_.frameStage()))
        asset.deliver->push_back(deliverable);
    return want(std::move(asset));
  }

  std::map<std::string, Wire> wiresOf(const ReportRecipe::Link& link) const {
    std::map<std::string, Wire> wires = link.inputs;
    wires.insert(reference_.inputs.begin(), reference_.inputs.end());
    return wires;
  }

  // What `link` adds one cause of error to, with nothing left out by measurement.
  std::size_t wantLink(Asset asset, const ReportRecipe::Link& link) {
    asset.keep_all = true;
    if (!link.reference) return wantPack(std::move(asset), false);
    for (const auto& [port, wire] : wiresOf(link))
      if (recipe_.stages.count(wire.stage) > 0) asset.wanted.push_back(wire.stage);
    return want(std::move(asset));
  }

  // An asset that the recipe's truth has nothing to say about begins with a later link's picture.
  void takeChain() {
    chain_ = how_.chain(problems_);
    truth_ = how_.truth();
    const JsonReader own(base_.report, base_.file, "/report");
    if (!own.has("truth")) return;
    const auto first = std::find_if(chain_.begin(), chain_.end(), [&](const ReportRecipe::Link& link) {
      return link.reference && link.cause == own.text("truth");
    });
    if (first == chain_.end())
      throw badInput(
          own.placeOf("truth"),
          "no link of the recipe's chain that is path-traced has the cause \"" + own.text("truth") + "\"");
    truth_ = *first;
    truth_.cause = ReportRecipe::kTruth;
    chain_.erase(chain_.begin(), first + 1);
  }

  void planVariants() {
    const std::vector<Variant> variants = variantsOf(vary());
    takeChain();
    truth_wanted_ = wantLink(assetFor(ReportRecipe::kTruth, truth_.settings), truth_);
    for (const Variant& variant : variants) {
      checkSameObject(variant);
      Wanted wanted{wantPack(assetFor(variant.name, variant.settings), true), {}};
      for (const ReportRecipe::Link& link : chain_) {
        std::vector<Setting> settings = variant.settings;
        settings.insert(settings.end(), link.settings.begin(), link.settings.end());
        wanted.links.push_back(wantLink(assetFor(variant.name + " (" + link.cause + ")", settings), link));
      }
      of_variant_.push_back(std::move(wanted));
      sweep_.variants.push_back({.variant = variant, .pack = 0, .frame = {}, .chain = {}});
    }
  }

  // As the tools say of their parameters.
  void checkSameObject(const Variant& variant) {
    for (const Setting& setting : variant.settings) {
      const auto stage = recipe_.stages.find(setting.stage);
      if (stage == recipe_.stages.end()) continue;  // which makeGraph reports
      const auto* parameter =
          tools_.require(stage->second.tool, {}).description.findParameter(setting.parameter);
      if (parameter != nullptr && parameter->changes_object)
        problems_.add(Error(ExitStatus::kUsage, {setting.option, "", ""},
                            setting.stage + "." + setting.parameter + " changes the object itself",
                            "variants of one object, whose pictures can be compared",
                            "make an asset of each"));
    }
  }

  // Assets of equal tasks become one: what differs only in what a link does not look at is made once.
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
  }

  bool isVariant(std::size_t kept) const {
    for (const Wanted& wanted : of_variant_)
      if (kept_[wanted.variant] == kept) return true;
    return false;
  }

  static std::string signature(const Graph& graph, std::size_t asset) {
    Json tasks = Json::array();
    for (const Task& task : graph.tasks)
      if (task.asset == asset && task.left_out != kNotNeeded)
        tasks.push_back({task.stage, task.parameters, task.left_out, task.rules.size(), task.measured.size(),
                         task.deliverables});
    return tasks.dump();
  }

  void planViews() {
    std::map<std::string, fs::path> lights = base_.report_lights;
    const bool own_light = lights.empty();
    if (own_light) lights["light"] = fs::path();
    const JsonReader own(base_.report, base_.file, "/report");
    const JsonReader cameras = own.has("cameras") ? own.object("cameras") : how_.cameras();
    const Json windowing = playersWindowing();
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

  // A figure that settles it is of the asset's own light and frame: for others the report finds it anew.
  Json playersWindowing() const {
    constexpr const char* kWindowing = "windowing";
    const auto frame = tasks_.find({kept_[of_variant_.front().variant], how_.frameStage()});
    if (frame == tasks_.end()) return nullptr;
    const Task& task = sweep_.graph.tasks[frame->second];
    for (const MeasuredParameter& parameter : task.measured)
      if (parameter.name == kWindowing) return "measured";
    const auto windowing = task.parameters.find(kWindowing);
    if (windowing == task.parameters.end() || *windowing == "rig") return nullptr;
    if (*windowing == "auto") return -1.0;
    return windowing->is_number() ? windowing->get<double>() : 0.0;
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
    const InstalledTool& tool = tools_.require(reference_.tool, {recipe_.file, "", "/report/reference/tool"});
    Json parameters = defaultParameters(tool.description);
    parameters.update(formats::checkParameters(tool.description, given, {recipe_.file, "", "/report/chain"}));
    return parameters;
  }

  // What `wire` brings to the reference of the asset `scene`; nothing if there is no such file.
  std::optional<Input> inputOf(const Wire& wire, const std::string& port, std::size_t scene, const View& view,
                               std::optional<TaskIndex> truth) {
    if (wire.stage == ReportRecipe::kTruth)
      return truth ? std::optional(Input{.maker = truth, .port = wire.port}) : std::nullopt;
    if (wire.stage == ReportRecipe::kView) {
      const fs::path& file = wire.port == "lights" ? view.lights : view.environment;
      return file.empty() ? std::nullopt : std::optional(Input{.port = wire.port, .file = file});
    }
    if (wire.fromAsset()) {
      const auto* input = tools_.require(reference_.tool, {}).description.findInput(port);
      return inputFrom(base_, wire.port, input == nullptr ? std::vector<std::string>() : input->parts);
    }
    return Input{.maker = tasks_.at({scene, wire.stage}), .port = wire.port};
  }

  // A path-traced picture of the asset `scene`; `link`'s parameters that are "same_as" another are those of
  // `values_of`. Its camera is that of the reference `truth`, as another mesh would be framed otherwise;
  // without one, `scene` is the truth.
  TaskIndex referenceTask(std::size_t scene, const ReportRecipe::Link& link, const View& view,
                          std::optional<TaskIndex> truth, std::size_t values_of) {
    Task task{.asset = scene, .stage = view.name, .tool = reference_.tool};
    for (const auto& [port, wire] : wiresOf(link))
      if (const auto input = inputOf(wire, port, scene, view, truth)) task.inputs[port] = *input;
    task.outputs[reference_.output] = reference_.file;
    task.parameters = referenceParameters(link, view, values_of);
    task.published = !truth;
    std::string key = std::to_string(scene) + view.name + (truth ? "" : " truth") + task.parameters.dump();
    for (const auto& [port, input] : task.inputs) key += " " + port;
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
    for (std::size_t i = 0; i < chain_.size(); ++i) {
      Link link{.cause = chain_[i].cause, .references = {}};
      const std::size_t asset = kept_[wanted.links[i]];
      if (chain_[i].reference)
        for (std::size_t view = 0; view < sweep_.views.size(); ++view)
          link.references.push_back(
              referenceTask(asset, chain_[i], sweep_.views[view], sweep_.truths[view], own));
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
  ReportRecipe::Reference reference_;
  ReportRecipe::Link truth_;
  std::vector<ReportRecipe::Link> chain_;
  std::vector<Asset> wanted_;
  std::vector<std::size_t> kept_;  // by wanted: place in the graph's assets
  std::size_t truth_wanted_ = 0;
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
