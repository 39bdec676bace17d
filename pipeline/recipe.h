// A recipe names the stages of one technique, how they are wired and their default parameters
// (configs/recipes/*.json; the syntax is in docs/PIPELINE.md).
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "pipeline/disk.h"

namespace bakelight::pipeline {

// A file that the asset supplies: "mesh", "environment".
struct AssetPort {
  std::string kind;  // as formats::PortDescription::kind
  bool required = true;
  // Lowercase, with the dot: which files of a folder without asset.json are taken for this port.
  std::vector<std::string> endings;
  formats::Json otherwise = {};  // what an asset's material has where it says nothing; null: nothing
};

// Where an input comes from: an output of a stage, or a file of the asset (stage == kAsset).
struct Wire {
  static constexpr const char* kAsset = "asset";
  std::string stage, port;

  bool fromAsset() const { return stage == kAsset; }
  std::string text() const { return stage + "." + port; }
};

// A measured figure may settle that a stage does less: "bounces" are left out where they add next to nothing. Or
// that it does nothing at all, and has no outputs.
struct LeaveOutRule {
  std::string what;    // is left out, for people
  Wire figure;         // a number in a stage's stats, as "survey.bounce_energy"
  double at_most = 0;  // the threshold, inclusive
  Wire error = {};     // the relative error that it adds, likewise; by default the figure itself
  // Parameter: value (as JSON without quotes; "*": any other) → what it becomes. Parameters with other values are not touched,
  // and a rule that would change nothing is none.
  std::map<std::string, std::map<std::string, formats::Json>> set = {};
  // What `current` of a parameter becomes; nothing if it stays.
  std::optional<formats::Json> changed(const std::string& parameter, const formats::Json& current) const;
  bool omit = false;    // the whole stage, which is not made then; sets nothing
  bool always = false;  // the stage has nothing to do then: judged even where nothing is to be left out
};

struct RecipeStage {
  std::string name, tool;
  std::map<std::string, Wire> inputs = {};  // by port of the tool
  std::map<std::string, std::string> outputs =
      {};  // file name by port; "{asset}" stands for the asset's name
  formats::Json parameters = formats::Json::object();
  std::map<std::string, Wire> linked = {};  // parameters that have the value of another stage's parameter
  std::map<std::string, Wire> measured =
      {};  // parameters that have the value of a figure, as "window.lambda"
  std::vector<LeaveOutRule> leave_out = {};

  bool mayBeOmitted() const;
  std::set<std::string> makers() const;  // stages that have to be done before: of inputs and of figures
};

struct Recipe {
  std::string name, summary;
  std::string file;  // for errors
  std::map<std::string, AssetPort> asset = {};
  std::map<std::string, RecipeStage> stages = {};
  std::map<std::string, Wire> deliverables =
      {};  // what a person asks for by name, and the stage output that it is

  formats::Json report = formats::Json::object();  // how variants are measured: see pipeline/sweep.h

  std::vector<std::string> stageNames() const;
  std::vector<std::string> deliverableNames() const;
};

// Throws ProblemsFound or Error(kBadInput) with JSON pointers: unknown keys, wires to stages or ports that do
// not exist, deliverables that nothing makes, two stages that wait for each other.
Recipe parseRecipe(const formats::Json& json, const std::string& name, const std::string& file);

// The stages of `recipe`, makers before users, ties by name. Throws Error(kBadInput) naming the stages of a
// cycle.
std::vector<std::string> stagesInOrder(const Recipe& recipe);

// `text` with "{asset}" replaced by `asset`. Throws Error(kBadInput) at `place` on any other {name}.
std::string expand(const std::string& text, const std::string& asset, const ErrorPlace& place);

// Recipes of one folder, read when first asked for.
class RecipeBook {
 public:
  static constexpr const char* kDefault = "prt";

  RecipeBook(std::filesystem::path folder, const Disk& disk) : folder_(std::move(folder)), disk_(disk) {}

  // With what the recipe builds on ("extends"): its own keys over those, objects key by key; null takes a key
  // away, and "name+" appends to the list "name". Throws Error(kBadInput) at `place` (where the name was
  // given) if there is no such recipe, where recipes build on each other in a circle, where a list that is to
  // be appended to is none; and as parseRecipe.
  const Recipe& require(const std::string& name, const ErrorPlace& place);
  std::vector<std::string> names() const;

 private:
  std::filesystem::path fileOf(const std::string& name) const;
  formats::Json whole(const std::string& name, const ErrorPlace& place,
                      std::vector<std::string> extending) const;

  std::filesystem::path folder_;
  const Disk& disk_;
  std::map<std::string, Recipe> read_;
};

}  // namespace bakelight::pipeline
