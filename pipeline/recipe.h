// A recipe names the stages of one technique, how they are wired and their default parameters
// (configs/recipes/*.json; the syntax is in docs/PIPELINE.md).
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
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
};

// Where an input comes from: an output of a stage, or a file of the asset (stage == kAsset).
struct Wire {
  static constexpr const char* kAsset = "asset";
  std::string stage, port;

  bool fromAsset() const { return stage == kAsset; }
  std::string text() const { return stage + "." + port; }
};

struct RecipeStage {
  std::string name, tool;
  std::map<std::string, Wire> inputs = {};  // by port of the tool
  std::map<std::string, std::string> outputs =
      {};  // file name by port; "{asset}" stands for the asset's name
  formats::Json parameters = formats::Json::object();
};

struct Recipe {
  std::string name, summary;
  std::string file;  // for errors
  std::map<std::string, AssetPort> asset = {};
  std::map<std::string, RecipeStage> stages = {};
  std::map<std::string, Wire> deliverables =
      {};  // what a person asks for by name, and the stage output that it is

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

  // Throws Error(kBadInput) at `place` (where the name was given) if there is no such recipe; and as
  // parseRecipe.
  const Recipe& require(const std::string& name, const ErrorPlace& place);
  std::vector<std::string> names() const;

 private:
  std::filesystem::path folder_;
  const Disk& disk_;
  std::map<std::string, Recipe> read_;
};

}  // namespace bakelight::pipeline
