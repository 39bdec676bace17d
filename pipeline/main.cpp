// `bakelight`: from asset folders to packs. The command line is read here; pipeline/commands.h does the rest.
#include <algorithm>
#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/words.h"
#include "pipeline/commands.h"
#include "pipeline/problems.h"

namespace fs = std::filesystem;
using namespace bakelight;
using pipeline::Request;

namespace {

// What is in the source tree wins over what is installed, so that a build folder needs no installation.
Request defaults() {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path in_source = BAKELIGHT_RECIPE_DIR;
  Request request;
  request.tools = folder;
  request.data = (folder / "../assets").lexically_normal();
  request.recipes =
      fs::exists(in_source) ? in_source : (folder / "../share/bakelight/recipes").lexically_normal();
  return request;
}

void addFolders(CLI::App& command, Request& request) {
  command.add_option("--tools", request.tools, "Folder of the tools")->capture_default_str();
  command.add_option("--recipes", request.recipes, "Folder of the recipes")->capture_default_str();
}

void addAssets(CLI::App& command, Request& request) {
  command.add_option("PATH", request.paths, "Asset folders, mesh files, or folders with several of these")
      ->required();
  command.add_option("--out", request.out, "Folder for all outputs and the cache")->capture_default_str();
  command.add_option("--data", request.data, "Folder that data:... in asset.json refers to")
      ->capture_default_str();
  command.add_option("--set", request.settings, "A parameter for all assets, as in transfer.order=5")
      ->type_name("STAGE.PARAMETER=VALUE")
      ->allow_extra_args(false);
  command.add_option("--deliver", request.deliver, "What to make, instead of all that the recipe delivers")
      ->delimiter(',')
      ->allow_extra_args(false);
  addFolders(command, request);
}

int report(const std::function<int()>& command) {
  const auto tell = [](const Error& error) { std::cerr << "bakelight: " << error.paragraph() << '\n'; };
  try {
    return command();
  } catch (const pipeline::ProblemsFound& found) {
    for (const Error& error : found.errors()) tell(error);
    return static_cast<int>(found.errors().front().status());
  } catch (const Error& error) {
    tell(error);
    return static_cast<int>(error.status());
  } catch (const std::exception& error) {
    tell(Error(ExitStatus::kNotAvailable, {}, std::string("internal error: ").append(error.what()), "",
               "report it with the command line and the asset"));
    return static_cast<int>(ExitStatus::kNotAvailable);
  }
}

// What a word of the command line that nobody knows comes nearest to: a command where one is expected, or an
// option of the command that is named.
std::string nearestWord(const CLI::App& app, int argc, char** argv) {
  const CLI::App* command = &app;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    std::vector<std::string> known;
    const bool is_option = word.starts_with("--");
    if (is_option) {
      for (const CLI::Option* option : command->get_options())
        for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    } else {
      for (const CLI::App* inner : command->get_subcommands([](const CLI::App*) { return true; }))
        known.push_back(inner->get_name());
    }
    if (known.empty()) continue;
    const std::string stem = word.substr(0, word.find('='));
    if (std::find(known.begin(), known.end(), stem) == known.end()) return formats::nearestName(stem, known);
    if (!is_option) command = command->get_subcommand(word);
  }
  return "";
}

int runCommandLine(int argc, char** argv) {
  CLI::App app("Bakes how light moves over an object, from an asset folder to one pack", "bakelight");
  app.set_version_flag("--version", BAKELIGHT_VERSION);
  app.require_subcommand(1);
  Request request = defaults();

  CLI::App& run = *app.add_subcommand("run", "Make what the assets deliver");
  addAssets(run, request);
  run.add_option("-j,--jobs", request.jobs, "Stages at once; 0: as many as there are cores")
      ->check(CLI::Range(0, 4096));
  run.add_option("--threads", request.cores, "Cores to share among the stages; 0: all")
      ->check(CLI::Range(0, 4096));
  run.add_flag("--dry-run,-n", request.dry_run, "Only tell what would be done");
  run.add_flag("--keep-all", request.keep_all, "Leave nothing out because of what was measured");
  CLI::App& sweep = *app.add_subcommand(
      "sweep", "Make variants of the assets, and measure error against run time: report.html");
  addAssets(sweep, request);
  sweep
      .add_option("--vary", request.vary,
                  "Values of a parameter, as in transfer.order=2..6 or pack.precision=float32,uint8; all "
                  "combinations")
      ->type_name("STAGE.PARAMETER=VALUE,...")
      ->allow_extra_args(false);
  sweep.add_option("-j,--jobs", request.jobs, "Stages at once; more than 1 disturbs the times")
      ->check(CLI::Range(0, 4096));
  sweep.add_option("--threads", request.cores, "Cores to share among the stages; 0: all")
      ->check(CLI::Range(0, 4096));
  CLI::App& baseline = *app.add_subcommand(
      "baseline", "Keep what every stage makes, and compare later runs with it; for continuous integration");
  baseline.require_subcommand(1);
  CLI::App& save = *baseline.add_subcommand("save", "Make the assets and keep all outputs");
  CLI::App& check =
      *baseline.add_subcommand("check", "Make the assets and compare; exit status 1 if anything differs");
  for (CLI::App* command : {&save, &check}) {
    addAssets(*command, request);
    command->add_option("--baseline", request.baseline, "Folder of the baseline; default: beside the asset");
    command->add_option("-j,--jobs", request.jobs, "Stages at once; 0: as many as there are cores")
        ->check(CLI::Range(0, 4096));
    command->add_option("--threads", request.cores, "Cores to share among the stages; 0: all")
        ->check(CLI::Range(0, 4096));
  }
  CLI::App& explain = *app.add_subcommand("explain", "Tell why each stage is up to date or not");
  addAssets(explain, request);
  CLI::App& graph = *app.add_subcommand("graph", "Print the stages and how they are wired");
  addAssets(graph, request);
  graph.add_option("--format", request.format, "dot (Graphviz), text or json")
      ->check(CLI::IsMember({"dot", "text", "json"}))
      ->capture_default_str();
  CLI::App& tools =
      *app.add_subcommand("tools", "List the tools of all recipes, as they describe themselves");
  addFolders(tools, request);

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const std::string meant = nearestWord(app, argc, argv);
    std::cerr << "bakelight: " << error.what()
              << ". Try: " << (meant.empty() ? "bakelight --help" : "\"" + meant + "\"") << ".\n";
    return static_cast<int>(ExitStatus::kUsage);
  }
  if (run.parsed()) return runCommand(request);
  if (save.parsed()) return saveBaselineCommand(request);
  if (check.parsed()) return checkBaselineCommand(request);
  if (sweep.parsed()) return sweepCommand(request);
  if (explain.parsed()) return explainCommand(request);
  if (graph.parsed()) return graphCommand(request);
  return toolsCommand(request);
}

}  // namespace

int main(int argc, char** argv) {
  return report([&] { return runCommandLine(argc, argv); });
}
