#include "workshop.h"

#include <utility>

#include "formats/error.h"
#include "formats/file.h"

namespace bakelight::pipeline {
using Json = nlohmann::json;
namespace {

Json port(const std::string& name, const std::string& kind, bool required = true) {
  return {{"name", name}, {"kind", kind}, {"required", required}, {"help", ""}};
}

Json integer(const std::string& name, int value, int minimum, int maximum) {
  return {{"name", name},       {"type", "integer"},  {"default", value},
          {"minimum", minimum}, {"maximum", maximum}, {"help", ""}};
}

Json description(const std::string& tool, Json inputs, Json outputs, Json parameters) {
  return {{"tool", tool},     {"summary", ""},      {"execution_path", ""},
          {"inputs", inputs}, {"outputs", outputs}, {"parameters", parameters}};
}

}  // namespace

Workshop::Workshop() {
  installAll();
  disk.write("recipes/prt.json", formats::readTextFile(BAKELIGHT_SOURCE_DIR "/tests/unit/pipeline/prt.json"));
  addAsset("cube", "eight corners");
  disk.write("assets/cube/sky.hdr", "blue");
}

void Workshop::installAll() {
  // Upper case does not matter to simplify, which is how a change of its input can leave its output the same.
  runner.install("simplify", {description("simplify", {port("mesh", "mesh"), port("texture", "image", false)},
                                          {port("simplified", "mesh")}, {integer("triangles", 100, 1, 1000)}),
                              [](const auto& inputs, const Json& parameters) {
                                std::string text = inputs.at("mesh");
                                for (char& c : text) c = static_cast<char>(std::tolower(c));
                                text += " at " + parameters.at("triangles").dump();
                                return std::map<std::string, std::string>{{"simplified", text}};
                              }});
  runner.install("transfer",
                 {description("transfer", {port("mesh", "mesh")}, {port("transfer", "tensors")},
                              {integer("order", 5, 1, 10)}),
                  [this](const auto& inputs, const Json& parameters) {
                    if (!failing_mesh.empty() && inputs.at("mesh").starts_with(failing_mesh))
                      throw badInput({"mesh", "face 3", ""}, "has no area");
                    return std::map<std::string, std::string>{
                        {"transfer", inputs.at("mesh") + " order " + parameters.at("order").dump()}};
                  }});
  runner.install(
      "pack",
      {description("pack", {port("mesh", "mesh"), port("transfer", "tensors")}, {port("pack", "pack")},
                   {{{"name", "name"}, {"type", "text"}, {"default", ""}, {"help", ""}}}),
       [](const auto& inputs, const Json& parameters) {
         return std::map<std::string, std::string>{
             {"pack", parameters.at("name").dump() + inputs.at("mesh") + inputs.at("transfer")}};
       }});
  runner.install("player", {description("player",
                                        {port("pack", "pack"), port("environment", "image", false),
                                         port("lights", "light_rig", false)},
                                        {port("image", "image", false)}, Json::array()),
                            [](const auto& inputs, const Json&) {
                              const auto sky = inputs.find("environment");
                              return std::map<std::string, std::string>{
                                  {"image", inputs.at("pack") + " under " +
                                                (sky == inputs.end() ? "no sky" : sky->second)}};
                            }});
}

void Workshop::addAsset(const std::string& name, const std::string& mesh_content) {
  disk.write("assets/" + name + "/" + name + ".obj", mesh_content);
}

void Workshop::writeAssetFile(const std::string& name, const Json& content) {
  disk.write("assets/" + name + "/asset.json", content.dump());
}

template <class Work>
auto Workshop::withGraph(const std::vector<std::filesystem::path>& paths, Work&& work) {
  Problems problems;
  Memo memo("out/.cache/memo.json", disk);
  RecipeBook recipes("recipes", disk);
  Toolbox tools("tools", "processor", disk, runner, memo);
  const Graph made =
      makeGraph(findAssets(paths, "data", recipes, disk, problems), recipes, tools, options, problems);
  problems.throwIfAny();
  OutputFolder out("out", made, disk, memo);
  Cache cache("out/.cache", disk, memo);
  std::vector<PastRecord> past;
  for (std::size_t asset = 0; asset < made.assets.size(); ++asset)
    past.emplace_back(out.recordOf(asset), disk);
  return work(made, tools, cache, out, memo, past);
}

BuildResult Workshop::run(std::vector<std::filesystem::path> paths) {
  return withGraph(paths, [&](const Graph& made, Toolbox& tools, Cache& cache, OutputFolder& out, Memo& memo,
                              const std::vector<PastRecord>& past) {
    BuildResult result = Build({made, tools, cache, out, memo, disk, runner, *this}, past, settings).run();
    memo.save();
    return result;
  });
}

std::map<std::string, std::string> Workshop::explain(std::vector<std::filesystem::path> paths) {
  return withGraph(paths, [&](const Graph& made, Toolbox& tools, Cache& cache, OutputFolder& out, Memo& memo,
                              const std::vector<PastRecord>& past) {
    std::map<std::string, std::string> told;
    for (const auto& explanation :
         pipeline::explain(made, Explainer(made, tools, cache, out, disk, memo, past)))
      told[made.tasks[explanation.task].stage] = std::string(nameOf(explanation.state)) +
                                                 (explanation.reason.empty() ? "" : ": ") +
                                                 explanation.reason;
    return told;
  });
}

Graph Workshop::graph(std::vector<std::filesystem::path> paths) {
  return withGraph(paths, [](const Graph& made, auto&...) { return made; });
}

std::vector<std::string> Workshop::problems(std::vector<std::filesystem::path> paths) {
  std::vector<std::string> paragraphs;
  try {
    graph(paths);
  } catch (const ProblemsFound& found) {
    for (const Error& error : found.errors()) paragraphs.push_back(error.paragraph());
  }
  return paragraphs;
}

Json Workshop::record(const std::string& asset) {
  return Json::parse(disk.read("out/" + asset + "/record.json"));
}

std::vector<std::string> Workshop::toolsStarted() {
  std::vector<std::string> names = runner.toolsStarted();
  runner.commands.clear();
  return names;
}

}  // namespace bakelight::pipeline
