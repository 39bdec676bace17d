// The contract that every tool fulfils. Parameters are declared once; the command line, the JSON keys, --help
// and --describe all come from that declaration. A tool's main declares, then hands run() a body that loads,
// computes, writes and reports; run() catches every error, prints one paragraph and returns the exit status.
//
// Every tool understands, besides its own inputs, outputs and parameters:
//   --parameters FILE   JSON object with parameter values; the command line wins over it
//   --threads N         worker threads, 0 = all cores (outputs never depend on it)
//   --stats FILE        write stats.json (formats/stage_record.h) there
//   --progress STYLE    auto, bar, lines, json, none
//   --describe          print the formats::ToolDescription as JSON and exit
//   --help, --version
// The path of the first required input may also stand alone, without its option: `inspect FILE`.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/json.h"
#include "formats/tool_description.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"
#include "tools/stage/progress.h"

namespace bakelight::stage {

// What a running tool's body sees.
class Run {
 public:
  Run(int threads, ProgressStyle style);

  int threads() const { return threads_; }  // >= 1
  ProgressStyle progressStyle() const { return style_; }
  // A figure for stats.json; the unit belongs in the name ("rays_per_s", "peak_bytes").
  void stat(const std::string& name, formats::Json value);
  // Shown at once and kept in stats.json.
  void warn(const std::string& text);
  Progress progress(std::string label, std::uint64_t total, std::string unit) const {
    return Progress(style_, std::move(label), total, std::move(unit));
  }

  const formats::Json& stats() const { return *stats_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  int threads_;
  ProgressStyle style_;
  std::shared_ptr<formats::Json> stats_;
  std::vector<std::string> warnings_;
};

class Tool {
 public:
  Tool(std::string name, std::string summary);
  ~Tool();

  // What the reference points to is filled in before the body runs. A parameter's default is the value that
  // the reference holds when it is declared.
  Tool& input(const std::string& name, const std::string& kind, std::filesystem::path& path,
              const std::string& help, bool required = true);
  struct InputOptions {
    bool required = true;
    std::vector<std::string> parts = {};  // see formats::PortDescription
  };
  Tool& input(const std::string& name, const std::string& kind, std::filesystem::path& path,
              const std::string& help, InputOptions options);
  Tool& output(const std::string& name, const std::string& kind, std::filesystem::path& path,
               const std::string& help, bool required = true);

  struct Range {
    double minimum, maximum;  // inclusive
  };
  Tool& parameter(const std::string& name, bool& value, const std::string& help);
  Tool& parameter(const std::string& name, int& value, Range range, const std::string& unit,
                  const std::string& help);
  Tool& parameter(const std::string& name, double& value, Range range, const std::string& unit,
                  const std::string& help);
  Tool& parameter(const std::string& name, formats::Float3& value, Range range, const std::string& unit,
                  const std::string& help);
  Tool& parameter(const std::string& name, std::string& value, std::vector<std::string> choices,
                  const std::string& help);

  // One of the words of an enumeration. `words` must outlive the tool's run.
  template <class Value, std::size_t N>
  Tool& parameter(const std::string& name, Value& value, const formats::Word<Value> (&words)[N],
                  const std::string& help) {
    return choice(
        name, formats::textsOf(words), formats::wordFor(words, value),
        [&value, &words](const std::string& text) { value = *formats::valueFor(words, text); }, help);
  }

  // A number, or one of the words: each stands for what it is paired with. The default is the first word, so
  // `value` must hold what that stands for.
  using Words = std::vector<std::pair<std::string, std::optional<double>>>;
  Tool& parameter(const std::string& name, std::optional<double>& value, const Words& words, Range range,
                  const std::string& help);

  // What was a parameter once, for those who still write it: an error that says where its value stands now.
  Tool& retired(const std::string& name, const std::string& instead);
  // See ParameterDescription::changes_object; of the parameter declared last.
  Tool& changesObject();

  // See ToolDescription::execution_path. Evaluated for --describe only.
  Tool& executionPath(std::function<std::string()> describe);

  // Without the execution path.
  formats::ToolDescription description() const;

  // Parses, runs `body`, writes the stats, reports errors. The process's exit status.
  int run(int argc, char** argv, const std::function<void(Run&)>& body);

 private:
  Tool& choice(const std::string& name, std::vector<std::string> words, const std::string& default_word,
               std::function<void(const std::string&)> choose, const std::string& help);

  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::stage
