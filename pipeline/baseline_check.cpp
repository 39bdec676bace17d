// checkBaseline of pipeline/baseline.h: pairs what was stored with what was made.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "formats/error.h"
#include "pipeline/baseline.h"
#include "pipeline/ingredients.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;

namespace {

std::string shortNumber(double value) {
  return fmt::format("{:.3g}", value);
}

template <class Map>
std::set<std::string> namesOf(const Map& map) {
  std::set<std::string> names;
  for (const auto& [name, value] : map) names.insert(name);
  return names;
}

class Checker {
 public:
  Checker(const fs::path& folder, const Comparer& compare, BaselineReport& report)
      : folder_(folder), compare_(compare), report_(report) {}

  void checkStage(const BaselineStage& stored, const MadeStage& made) {
    tellChanges(stored, made);
    std::set<std::string> ports = namesOf(stored.outputs);
    ports.merge(namesOf(made.entry.outputs));
    for (const std::string& port : ports) checkOutput(stored, made, port);
    checkCounts(stored, made);
  }

  void missing(const std::string& stage, const std::string& output, const std::string& kind,
               const std::string& who_has_it) {
    report_.rows.push_back({stage, output, kind, "only " + who_has_it + " has it", "", "", false});
  }

 private:
  void tellChanges(const BaselineStage& stored, const MadeStage& made) {
    Ingredients before, now;
    before.tool = stored.tool, before.parameters = stored.parameters;
    before.execution_path = stored.execution_path, now.execution_path = made.execution_path;
    now.tool = made.tool, now.parameters = made.parameters;
    for (const std::string& phrase : differences(before, now, {}))
      report_.notes.push_back(made.stage + ": " + phrase + " since the baseline was saved");
  }

  void checkOutput(const BaselineStage& stored, const MadeStage& made, const std::string& port) {
    const auto reference = stored.outputs.find(port);
    const auto file = made.entry.outputs.find(port);
    if (reference == stored.outputs.end()) return missing(made.stage, port, made.kinds.at(port), "this run");
    const BaselineOutput& output = reference->second;
    if (file == made.entry.outputs.end()) return missing(made.stage, port, output.kind, "the baseline");
    ++report_.compared_outputs;
    const BaselineRow row{made.stage, port, output.kind, "", "", "", true};
    if (made.kinds.at(port) != output.kind)
      add(row, "kind: now " + made.kinds.at(port), "", "", false);
    else if (file->second.hash == output.hash)
      add(row, "bytes", "equal", "", true);
    else if (!hasLimits(output.kind))
      add(row, "bytes", "differ", "equal", false);
    else
      addComparison(
          row, compare_(output.kind, made.entry.pathOf(file->second), folder_ / output.file, output.limits));
  }

  void addComparison(const BaselineRow& row, const formats::Comparison& comparison) {
    for (const std::string& mismatch : comparison.mismatches) add(row, mismatch, "", "", false);
    for (const formats::Difference& difference : comparison.differences)
      add(row, difference.what, shortNumber(difference.measured), shortNumber(difference.limit),
          difference.passes());
    if (comparison.compared_values == 0) add(row, "nothing was compared", "", "", false);
  }

  // One row for all that agree, one for each that does not.
  void checkCounts(const BaselineStage& stored, const MadeStage& made) {
    const BaselineRow row{made.stage, "", "counts", "", "", "", true};
    const std::map<std::string, std::int64_t> counts = countsOf(made.entry.run.stats);
    std::set<std::string> names = namesOf(stored.counts);
    names.merge(namesOf(counts));
    std::size_t equal = 0;
    for (const std::string& name : names) {
      if (std::find(stored.ignored_counts.begin(), stored.ignored_counts.end(), name) !=
          stored.ignored_counts.end())
        continue;
      const auto expected = stored.counts.find(name), count = counts.find(name);
      if (expected != stored.counts.end() && count != counts.end() && expected->second == count->second)
        ++equal;
      else
        add(row, name, count == counts.end() ? "none" : std::to_string(count->second),
            expected == stored.counts.end() ? "none" : std::to_string(expected->second), false);
    }
    if (equal > 0) add(row, std::to_string(equal) + (equal == 1 ? " count" : " counts"), "equal", "", true);
  }

  void add(BaselineRow row, const std::string& figure, const std::string& measured, const std::string& limit,
           bool passes) {
    row.figure = figure, row.measured = measured, row.limit = limit, row.passes = passes;
    report_.rows.push_back(std::move(row));
  }

  const fs::path& folder_;
  const Comparer& compare_;
  BaselineReport& report_;
};

// Characters, as a terminal counts them: bytes of UTF-8 that do not continue one.
std::size_t widthOf(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

using Cells = std::vector<std::string>;

Cells cellsOf(const BaselineRow& row) {
  return {
      row.stage, row.output, row.kind, row.figure, row.measured, row.limit, row.passes ? "ok" : "DIFFERS"};
}

std::string tableOf(const std::vector<BaselineRow>& rows) {
  std::vector<Cells> lines = {{"stage", "output", "kind", "figure", "measured", "limit", ""}};
  for (const BaselineRow& row : rows) lines.push_back(cellsOf(row));
  std::vector<std::size_t> widths(lines.front().size(), 0);
  for (const Cells& cells : lines)
    for (std::size_t column = 0; column < cells.size(); ++column)
      widths[column] = std::max(widths[column], widthOf(cells[column]));
  std::string text;
  for (const Cells& cells : lines) {
    std::string line;
    for (std::size_t column = 0; column < cells.size(); ++column)
      line += cells[column] + std::string(widths[column] - widthOf(cells[column]) + 2, ' ');
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace

std::size_t BaselineReport::differenceCount() const {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const BaselineRow& row) { return !row.passes; }));
}

bool BaselineReport::passes() const {
  return compared_outputs > 0 && differenceCount() == 0;
}

BaselineReport checkBaseline(const MadeAsset& made, const fs::path& folder, const Disk& disk,
                             const Comparer& compare) {
  const Baseline baseline = readBaseline(folder, disk);
  if (baseline.recipe != made.recipe)
    throw badInput(
        {(folder / kBaselineFile).string(), "", "/recipe"},
        "the baseline is of the recipe \"" + baseline.recipe + "\", the asset has \"" + made.recipe + "\"",
        "one and the same recipe", "save the baseline again");
  BaselineReport report;
  Checker checker(folder, compare, report);
  std::set<std::string> made_names;
  for (const MadeStage& stage : made.stages) {
    made_names.insert(stage.stage);
    const auto stored = baseline.stages.find(stage.stage);
    if (stored != baseline.stages.end())
      checker.checkStage(stored->second, stage);
    else
      checker.missing(stage.stage, "", "stage", "this run");
  }
  for (const auto& [name, stage] : baseline.stages)
    if (!made_names.contains(name)) {
      checker.missing(name, "", "stage", "the baseline");
      if (const auto why = made.left_out.find(name); why != made.left_out.end())
        report.notes.push_back(name + ": left out in this run (" + why->second + ")");
    }
  return report;
}

void print(const BaselineReport& report, std::ostream& out) {
  for (const std::string& note : report.notes) out << note << '\n';
  out << tableOf(report.rows);
  const std::size_t count = report.differenceCount();
  if (report.compared_outputs == 0)
    out << "nothing was compared\n";
  else if (count == 0)
    out << report.compared_outputs << " outputs are as in the baseline\n";
  else
    out << count << (count == 1 ? " difference" : " differences") << " from the baseline\n";
}

}  // namespace bakelight::pipeline
