#include "tools/stage/stage.h"

#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/stage_record.h"
#include "formats/words.h"

namespace bakelight::stage {

using formats::Json;
using formats::ParameterDescription;
using formats::ParameterType;
using formats::PortDescription;
namespace fs = std::filesystem;

namespace {

struct Port {
  PortDescription description;
  fs::path* path;
};

struct Parameter {
  ParameterDescription description;
  std::function<void(const Json&)> assign;  // takes a checked, canonical value
};

// The options that every tool has.
struct CommonOptions {
  std::string parameters_file, stats_file, progress = "auto";
  int threads = 0;
  bool describe = false;
};

std::string optionName(const std::string& name) {
  std::string option = "--" + name;
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

// The first required input may also be given without its option: `inspect FILE`.
bool takesPlainArgument(const std::vector<Port>& inputs, const Port& port) {
  const auto first = std::find_if(inputs.begin(), inputs.end(),
                                  [](const Port& input) { return input.description.required; });
  return first != inputs.end() && &*first == &port;
}

// What stands behind an option in --help: "INTEGER from 1 to 10 [5]".
std::string helpText(const ParameterDescription& parameter) {
  std::string text = parameter.help + " (" + formats::expectation(parameter);
  if (!parameter.unit.empty()) text += ", " + parameter.unit;
  const Json& value = parameter.default_value;
  return text + "; default " + (value.is_string() ? value.get<std::string>() : value.dump()) + ")";
}

// A command-line word as the JSON value that a parameter file would hold. Words that do not parse become
// strings, so that checkParameter complains about them in its own terms.
Json jsonFromWords(const ParameterDescription& parameter, const std::vector<std::string>& words) {
  const auto one = [](const std::string& word) {
    const Json parsed = Json::parse(word, nullptr, false);
    return parsed.is_discarded() ? Json(word) : parsed;
  };
  if (parameter.type == ParameterType::kText) return words.front();
  if (parameter.type != ParameterType::kRealList) return one(words.front());
  Json list = Json::array();
  for (const auto& word : words) list.push_back(one(word));
  return list;
}

ProgressStyle progressStyle(const std::string& name) {
  if (name == "bar") return ProgressStyle::kBar;
  if (name == "lines") return ProgressStyle::kLines;
  if (name == "json") return ProgressStyle::kJson;
  if (name == "none") return ProgressStyle::kNone;
  return automaticProgressStyle();
}

bool reportsAsJson(const CommonOptions& common) {
  return common.progress == "json";
}

void printJsonLine(const Json& line) {
  std::fprintf(stderr, "%s\n", line.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
}

int report(const std::string& tool, const Error& error, bool as_json) {
  if (as_json)
    printJsonLine({{"error",
                    {{"file", error.place().file},
                     {"element", error.place().element},
                     {"pointer", error.place().pointer},
                     {"problem", error.problem()},
                     {"expected", error.expected()},
                     {"remedy", error.remedy()},
                     {"paragraph", error.paragraph()},
                     {"status", static_cast<int>(error.status())}}}});
  else
    std::fprintf(stderr, "%s: %s\n", tool.c_str(), error.paragraph().c_str());
  return static_cast<int>(error.status());
}

// A stage writes whole files under temporary names, so stopping at any instant loses nothing but the run.
void stopAtSignals() {
  struct sigaction action {};
  action.sa_handler = [](int) {
    formats::removeUnfinishedFile();
    ::_exit(static_cast<int>(ExitStatus::kInterrupted));
  };
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  // A file-size limit then shows as a failed write, which is reported like a full disk.
  ::signal(SIGXFSZ, SIG_IGN);
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

formats::StageRecord measuredRecord(const std::string& tool, const Run& run,
                                    std::chrono::steady_clock::time_point start) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  formats::StageRecord record;
  record.tool = tool;
  record.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  record.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  record.peak_memory_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  record.warnings = run.warnings();
  record.stats = run.stats();
  return record;
}

}  // namespace

Run::Run(int threads, ProgressStyle style)
    : threads_(threads), style_(style), stats_(std::make_shared<Json>(Json::object())) {}

void Run::stat(const std::string& name, Json value) {
  (*stats_)[name] = std::move(value);
}

void Run::warn(const std::string& text) {
  warnings_.push_back(text);
  if (style_ == ProgressStyle::kJson)
    printJsonLine({{"warning", text}});
  else
    spdlog::warn(text);
}

struct Tool::Implementation {
  std::string name, summary;
  std::vector<Port> inputs, outputs;
  std::vector<Parameter> parameters;
  std::vector<formats::RetiredParameter> retired;
  std::function<std::string()> execution_path = [] { return std::string(); };

  Parameter& add(ParameterDescription description, std::function<void(const Json&)> assign) {
    return parameters.emplace_back(Parameter{std::move(description), std::move(assign)});
  }
};

Tool::Tool(std::string name, std::string summary) : implementation_(std::make_unique<Implementation>()) {
  implementation_->name = std::move(name);
  implementation_->summary = std::move(summary);
}

Tool::~Tool() = default;

Tool& Tool::input(const std::string& name, const std::string& kind, fs::path& path, const std::string& help,
                  bool required) {
  return input(name, kind, path, help, InputOptions{.required = required});
}

Tool& Tool::input(const std::string& name, const std::string& kind, fs::path& path, const std::string& help,
                  InputOptions options) {
  implementation_->inputs.push_back({{name, kind, options.required, help, std::move(options.parts)}, &path});
  return *this;
}

Tool& Tool::output(const std::string& name, const std::string& kind, fs::path& path, const std::string& help,
                   bool required) {
  implementation_->outputs.push_back({{name, kind, required, help}, &path});
  return *this;
}

namespace {

ParameterDescription describe(const std::string& name, ParameterType type, Json default_value,
                              const std::string& unit, const std::string& help) {
  ParameterDescription description;
  description.name = name;
  description.type = type;
  description.default_value = std::move(default_value);
  description.unit = unit;
  description.help = help;
  return description;
}

ParameterDescription withRange(ParameterDescription description, Tool::Range range) {
  description.minimum = range.minimum;
  description.maximum = range.maximum;
  return description;
}

}  // namespace

Tool& Tool::parameter(const std::string& name, bool& value, const std::string& help) {
  implementation_->add(describe(name, ParameterType::kBoolean, value, "", help),
                       [&value](const Json& json) { value = json.get<bool>(); });
  return *this;
}

Tool& Tool::parameter(const std::string& name, int& value, Range range, const std::string& unit,
                      const std::string& help) {
  implementation_->add(withRange(describe(name, ParameterType::kInteger, value, unit, help), range),
                       [&value](const Json& json) { value = json.get<int>(); });
  return *this;
}

Tool& Tool::parameter(const std::string& name, double& value, Range range, const std::string& unit,
                      const std::string& help) {
  implementation_->add(withRange(describe(name, ParameterType::kReal, value, unit, help), range),
                       [&value](const Json& json) { value = json.get<double>(); });
  return *this;
}

Tool& Tool::parameter(const std::string& name, formats::Float3& value, Range range, const std::string& unit,
                      const std::string& help) {
  Json default_value = Json::array();
  for (const float element : value) default_value.push_back(formats::shortestDouble(element));
  ParameterDescription description =
      withRange(describe(name, ParameterType::kRealList, default_value, unit, help), range);
  description.length = 3;
  implementation_->add(std::move(description), [&value](const Json& json) {
    for (std::size_t i = 0; i < 3; ++i) value[i] = json[i].get<float>();
  });
  return *this;
}

Tool& Tool::parameter(const std::string& name, std::string& value, std::vector<std::string> choices,
                      const std::string& help) {
  ParameterDescription description = describe(name, ParameterType::kText, value, "", help);
  description.choices = std::move(choices);
  implementation_->add(std::move(description),
                       [&value](const Json& json) { value = json.get<std::string>(); });
  return *this;
}

Tool& Tool::choice(const std::string& name, std::vector<std::string> words, const std::string& default_word,
                   std::function<void(const std::string&)> choose, const std::string& help) {
  ParameterDescription description = describe(name, ParameterType::kText, default_word, "", help);
  description.choices = std::move(words);
  implementation_->add(std::move(description),
                       [choose = std::move(choose)](const Json& json) { choose(json.get<std::string>()); });
  return *this;
}

Tool& Tool::parameter(const std::string& name, std::optional<double>& value, const Words& words, Range range,
                      const std::string& help) {
  ParameterDescription description =
      withRange(describe(name, ParameterType::kReal, words.at(0).first, "", help), range);
  for (const auto& [word, meaning] : words) description.choices.push_back(word);
  implementation_->add(std::move(description), [&value, words](const Json& json) {
    if (!json.is_string()) return static_cast<void>(value = json.get<double>());
    for (const auto& [word, meaning] : words)
      if (json == word) value = meaning;
  });
  return *this;
}

Tool& Tool::retired(const std::string& name, const std::string& instead) {
  implementation_->retired.push_back({name, instead});
  return *this;
}

Tool& Tool::changesObject() {
  implementation_->parameters.back().description.changes_object = true;
  return *this;
}

Tool& Tool::executionPath(std::function<std::string()> describe_path) {
  implementation_->execution_path = std::move(describe_path);
  return *this;
}

formats::ToolDescription Tool::description() const {
  formats::ToolDescription description;
  description.tool = implementation_->name;
  description.summary = implementation_->summary;
  for (const auto& port : implementation_->inputs) description.inputs.push_back(port.description);
  for (const auto& port : implementation_->outputs) description.outputs.push_back(port.description);
  for (const auto& parameter : implementation_->parameters)
    description.parameters.push_back(parameter.description);
  description.retired = implementation_->retired;
  return description;
}

namespace {

// The command line of one run: declared from the tool's own declaration, then read in three steps, so that a
// wrong word is reported before any file is opened.
class CommandLine {
 public:
  CommandLine(const std::string& name, const std::string& summary, std::vector<Port>& inputs,
              std::vector<Port>& outputs, std::vector<Parameter>& parameters)
      : name_(name),
        inputs_(inputs),
        outputs_(outputs),
        parameters_(parameters),
        words_(parameters.size()),
        app_(summary, name) {
    app_.set_version_flag("--version", name + " (Bakelight) " BAKELIGHT_VERSION);
    app_.get_formatter()->column_width(32);
    for (Port& port : inputs_) declarePort(port, "Inputs");
    for (Port& port : outputs_) declarePort(port, "Outputs");
    for (std::size_t i = 0; i < parameters_.size(); ++i)
      declareParameter(parameters_[i].description, words_[i]);
    declareCommonOptions();
  }

  // Throws CLI::ParseError, which also stands for --help and --version.
  void parse(int argc, char** argv) { app_.parse(argc, argv); }
  int exit(const CLI::ParseError& outcome) const { return app_.exit(outcome); }
  const CommonOptions& common() const { return common_; }

  // What the first option that there is not comes nearest to; "" if nothing does.
  std::string nearestOption(int argc, char** argv) const {
    std::vector<std::string> known;
    for (const CLI::Option* option : app_.get_options())
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    for (int i = 1; i < argc; ++i) {
      const std::string word = argv[i], stem = word.substr(0, word.find('='));
      if (stem.starts_with("--") && std::find(known.begin(), known.end(), stem) == known.end())
        return formats::nearestName(stem, known);
    }
    return "";
  }

  // Parameter file first, then the command line, which wins.
  void assignParameters(const formats::ToolDescription& description) const {
    if (!common_.parameters_file.empty()) {
      const Json values = formats::readJson(common_.parameters_file);
      const Json checked = formats::checkParameters(description, values, {common_.parameters_file, "", ""});
      for (const Parameter& parameter : parameters_)
        if (checked.contains(parameter.description.name))
          parameter.assign(checked[parameter.description.name]);
    }
    for (std::size_t i = 0; i < words_.size(); ++i)
      if (app_.get_option(optionName(parameters_[i].description.name))->count() > 0)
        assignFromWords(parameters_[i], words_[i]);
  }

  void requirePorts() const {
    for (const auto* ports : {&inputs_, &outputs_})
      for (const Port& port : *ports)
        if (port.description.required && port.path->empty())
          throw Error(ExitStatus::kUsage, {}, optionName(port.description.name) + " is missing",
                      port.description.help + " (" + port.description.kind + ")",
                      name_ + " --help for an overview");
  }

 private:
  void declarePort(Port& port, const std::string& group) {
    std::string names = optionName(port.description.name);
    if (takesPlainArgument(inputs_, port)) names += "," + port.description.name;
    const std::string kind = port.description.kind + (port.description.required ? "" : ", optional");
    app_.add_option_function<std::string>(
            names, [&port](const std::string& path) { *port.path = path; },
            port.description.help + " (" + kind + ")")
        ->type_name("PATH")
        ->group(group);
  }

  void declareParameter(const ParameterDescription& description, std::vector<std::string>& words) {
    auto* option = app_.add_option(optionName(description.name), words, helpText(description));
    option->type_name("")
        ->expected(description.type == ParameterType::kRealList ? description.length : 1)
        ->allow_extra_args(false)  // `--order 5 FILE`: FILE is no second value
        ->group("Parameters");
    // --flag alone means true.
    if (description.type == ParameterType::kBoolean) option->expected(0, 1)->default_str("true");
  }

  void declareCommonOptions() {
    const auto file = [&](const char* name, std::string& path, const char* help) {
      app_.add_option(name, path, help)->type_name("FILE")->group("Common");
    };
    file("--parameters", common_.parameters_file,
         "JSON object with parameters; options given here win over it");
    file("--stats", common_.stats_file, "Write timings, counts and warnings there (stats.json)");
    app_.add_option("--threads", common_.threads, "Worker threads, 0 = all cores; outputs never depend on it")
        ->check(CLI::Range(0, 4096))
        ->group("Common");
    app_.add_option("--progress", common_.progress, "auto, bar, lines, json or none")
        ->check(CLI::IsMember({"auto", "bar", "lines", "json", "none"}))
        ->group("Common");
    app_.add_flag("--describe", common_.describe, "Print inputs, outputs and parameters as JSON")
        ->group("Common");
  }

  static void assignFromWords(const Parameter& parameter, std::vector<std::string> words) {
    if (words.empty()) words = {"true"};
    const ErrorPlace place{"", optionName(parameter.description.name), ""};
    try {
      const Json value = jsonFromWords(parameter.description, words);
      parameter.assign(formats::checkParameter(parameter.description, value, place));
    } catch (const Error& error) {
      throw Error(ExitStatus::kUsage, place, error.problem(), error.expected(), error.remedy());
    }
  }

  const std::string& name_;
  std::vector<Port>& inputs_;
  std::vector<Port>& outputs_;
  std::vector<Parameter>& parameters_;
  std::vector<std::vector<std::string>> words_;  // of each parameter, as typed
  CommonOptions common_;
  CLI::App app_;
};

// The one place where errors end: as a paragraph (or a JSON line for the driver) and an exit status.
int runGuarded(const std::string& tool, bool as_json, const std::function<void()>& work) {
  try {
    work();
    return static_cast<int>(ExitStatus::kDone);
  } catch (const Error& error) {
    return report(tool, error, as_json);
  } catch (const std::bad_alloc&) {
    return report(tool,
                  Error(ExitStatus::kNotAvailable, {}, "this machine's memory is not enough", "",
                        "a smaller mesh, a lower order, or a machine with more memory"),
                  as_json);
  } catch (const std::exception& error) {
    return report(tool,
                  Error(ExitStatus::kNotAvailable, {}, std::string("internal error: ") + error.what(), "",
                        "report it with the command line and the inputs"),
                  as_json);
  }
}

// What to write instead of the first option that there is no more; "" if there is none.
std::string retiredOption(const std::vector<formats::RetiredParameter>& retired, int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i], stem = word.substr(0, word.find('='));
    for (const formats::RetiredParameter& was : retired)
      if (stem == optionName(was.name)) return was.instead;
  }
  return "";
}

void logToStandardError(const std::string& tool) {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  const char* no_color = std::getenv("NO_COLOR");  // no-color.org
  if (no_color != nullptr && *no_color != '\0') sink->set_color_mode(spdlog::color_mode::never);
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(tool, std::move(sink)));
  spdlog::set_pattern("%n: %^%l%$: %v");
}

}  // namespace

int Tool::run(int argc, char** argv, const std::function<void(Run&)>& body) {
  const auto start = std::chrono::steady_clock::now();
  Implementation& tool = *implementation_;
  CommandLine command_line(tool.name, tool.summary, tool.inputs, tool.outputs, tool.parameters);
  const CommonOptions& common = command_line.common();
  try {
    command_line.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    return command_line.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    const std::string instead = retiredOption(tool.retired, argc, argv);
    const std::string meant = instead.empty() ? command_line.nearestOption(argc, argv) : instead;
    const Error usage(ExitStatus::kUsage, {}, error.what(), "",
                      meant.empty() ? tool.name + " --help for what there is" : meant);
    return report(tool.name, usage, reportsAsJson(common));
  }

  logToStandardError(tool.name);
  stopAtSignals();
  return runGuarded(tool.name, reportsAsJson(common), [&] {
    if (common.describe) {
      formats::ToolDescription described = description();
      described.execution_path = tool.execution_path();
      std::cout << formats::toJson(described).dump(2) << "\n";
      return;
    }
    command_line.assignParameters(description());
    command_line.requirePorts();

    const int threads = common.threads > 0 ? common.threads : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    Run run(threads, progressStyle(common.progress));
    body(run);
    if (!common.stats_file.empty())
      formats::writeJson(common.stats_file, formats::toJson(measuredRecord(tool.name, run, start)));
  });
}

}  // namespace bakelight::stage
