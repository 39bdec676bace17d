// Assets: what the user wants baked. Found in folders, or told by asset.json (docs/PIPELINE.md).
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/json.h"
#include "formats/material.h"
#include "pipeline/disk.h"
#include "pipeline/problems.h"
#include "pipeline/recipe.h"

namespace bakelight::pipeline {

// A parameter given as text, on the command line or by a variant.
struct Setting {
  std::string stage, parameter, value;
  std::string option;  // as it was typed, for errors
};
// From "transfer.order=5". Throws Error(kUsage).
Setting parseSetting(const std::string& text);

struct Asset {
  std::string name;        // a file name: the folder in the output folder
  std::string label = {};  // what {asset} stands for in recipes; empty: the name
  std::string file;        // asset.json as the user would name it, or the mesh: for errors
  std::string recipe = RecipeBook::kDefault;
  std::map<std::string, std::filesystem::path> files = {};   // by asset port of the recipe; all exist
  std::map<std::string, formats::Materials> materials = {};  // by asset port; tables are not read
  std::vector<std::string> wanted = {};            // stages that run though nothing delivered needs them
  formats::Json stages = formats::Json::object();  // overrides: stage → parameter → value, not checked yet
  std::optional<std::vector<std::string>> deliver = {};  // nothing: all that the recipe delivers
  bool keep_all = false;                                 // nothing is left out by a measured figure
  std::set<std::string> kept = {};                       // stages of which nothing is, of the recipe
  formats::Json report = formats::Json::object();        // what is varied and shown: see pipeline/sweep.h
  bool report_with_run = false;                          // of it: a run ends with its sweep
  std::map<std::string, std::filesystem::path> report_lights = {};  // of it, by name; all exist
  std::vector<Setting> settings = {};  // of a variant; stronger than everything else
  formats::Json budget = {};           // see pipeline/budget.h; null: none
  formats::Json choice = {};           // the variant that keeps it; null: none

  bool supplies(const std::string& port) const { return files.count(port) + materials.count(port) > 0; }
};

// The assets that `paths` stand for, in their order: a folder with asset.json, a folder with one mesh file, a
// mesh file, or a folder with several of these. Every mistake is put into `problems`; what could be read is
// returned. `data_folder` is what "data:..." in asset.json is relative to.
std::vector<Asset> findAssets(const std::vector<std::filesystem::path>& paths,
                              const std::filesystem::path& data_folder, RecipeBook& recipes, const Disk& disk,
                              Problems& problems);

}  // namespace bakelight::pipeline
