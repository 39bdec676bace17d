#include "tools/report/page_tables.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>

#include "tools/report/text.h"

namespace bakelight::report {
namespace {

std::string cell(const std::string& text, const char* kind = "") {
  return (*kind ? "<td class=\"" + std::string(kind) + "\">" : "<td>") + text + "</td>";
}

struct Heading {
  std::string text, unit;
  bool is_text = false;
};

std::string tableBegin(const std::vector<Heading>& headings, const char* kind = "") {
  std::string html = "<div class=\"scroll\"><table" +
                     (*kind ? " class=\"" + std::string(kind) + "\"" : std::string()) + "><thead><tr>";
  for (const Heading& heading : headings)
    html += (heading.is_text ? "<th class=\"text\">" : "<th>") + escaped(heading.text) +
            (heading.unit.empty() ? "" : "<span class=\"unit\">" + escaped(heading.unit) + "</span>") +
            "</th>";
  return html + "</tr></thead><tbody>\n";
}

constexpr const char* kTableEnd = "</tbody></table></div>\n";

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string range(double low, double high) {
  return "<span class=\"range\">" + numberText(low) + "–" + numberText(high) + "</span>";
}

// ---- Variants ----

struct Column {
  Heading heading;
  std::function<std::optional<double>(std::size_t)> value;  // of a variant
  std::string (*text)(double);
  std::function<std::string(std::size_t)> detail = [](std::size_t) { return std::string(); };
};

std::string hundredfoldText(double value) {
  return numberText(100 * value);
}
std::string plainText(double value) {
  return numberText(value);
}
std::string sizeText(double bytes) {
  return bytesText(static_cast<std::uint64_t>(bytes));
}

std::vector<Column> variantColumns(const Plan& plan, const Evaluation& evaluation) {
  const std::vector<VariantFigures>& figures = evaluation.variants;
  const auto error = [&figures](double ErrorFigures::*member) {
    return [&figures, member](std::size_t v) { return figures[v].errors.*member; };
  };
  std::vector<Column> columns = {
      {{"error", "rel. RMSE, %"}, error(&ErrorFigures::rel_rmse), hundredfoldText},
      {{"p99", "%"}, error(&ErrorFigures::p99), hundredfoldText},
      {{"FLIP", "mean"}, error(&ErrorFigures::flip), plainText},
      {{"coverage", "error, %"}, error(&ErrorFigures::coverage_error), hundredfoldText},
      {{"frame", "CPU, ms"}, [&](std::size_t v) { return figures[v].frame_ms(); }, plainText}};
  const auto time = [&](const char* name, Spread VariantFigures::*member) {
    columns.push_back({{name, "CPU, ms"},
                       [&figures, member](std::size_t v) { return (figures[v].*member).median; },
                       plainText,
                       [&figures, member](std::size_t v) {
                         return range((figures[v].*member).low, (figures[v].*member).high);
                       }});
  };
  time("light change", &VariantFigures::light_change_ms);
  time("view change", &VariantFigures::view_change_ms);
  // A column where any variant has such a time.
  using GlTime = std::optional<Spread> (*)(const GlTimes&);
  const auto gl = [&](const char* name, const char* unit, GlTime time_of) {
    const auto times = [&plan, time_of](std::size_t v) {
      const std::optional<GlTimes>& measured = plan.variants[v].gl;
      return measured ? time_of(*measured) : std::nullopt;
    };
    bool any = false;
    for (std::size_t v = 0; v < plan.variants.size(); ++v) any = any || times(v);
    if (!any) return;
    columns.push_back({{name, unit},
                       [times](std::size_t v) {
                         const std::optional<Spread> spread = times(v);
                         return spread ? std::optional<double>(spread->median) : std::nullopt;
                       },
                       plainText,
                       [times](std::size_t v) { return range(times(v)->low, times(v)->high); }});
  };
  gl("light change", "OpenGL, ms", [](const GlTimes& t) { return std::optional(t.light_change_ms); });
  gl("light change", "GPU, ms", [](const GlTimes& t) { return t.gpu_light_change_ms; });
  gl("frame", "OpenGL, ms", [](const GlTimes& t) { return std::optional(t.frame_ms); });
  gl("frame", "GPU, ms", [](const GlTimes& t) { return t.gpu_frame_ms; });
  columns.push_back(
      {{"pack", "size"}, [&](std::size_t v) { return static_cast<double>(figures[v].bytes); }, sizeText});
  columns.push_back({{"bake", "s"}, [&](std::size_t v) { return figures[v].bake_s; }, plainText});
  columns.push_back({{"bake", "CPU s"}, [&](std::size_t v) { return figures[v].bake_cpu_s; }, plainText});
  return columns;
}

// Nothing for a column that says the same of all.
std::optional<double> leastOf(const Column& column, std::size_t variants) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (std::size_t v = 0; v < variants; ++v)
    if (const std::optional<double> value = column.value(v)) {
      least = std::min(least, *value);
      most = std::max(most, *value);
    }
  return least < most ? std::optional(least) : std::nullopt;
}

std::string variantCell(const Column& column, std::size_t variant, const std::optional<double>& least) {
  const std::optional<double> value = column.value(variant);
  if (!value) return cell("–");
  const bool is_least = value == least;
  return cell(column.text(*value) + "<span class=\"mark\">" + (is_least ? "▾" : "") + "</span>" +
                  column.detail(variant),
              is_least ? "least" : "");
}

bool contains(const std::vector<std::size_t>& front, std::size_t variant) {
  return std::find(front.begin(), front.end(), variant) != front.end();
}

std::string frontsOf(const Fronts& fronts, std::size_t variant) {
  std::string text;
  const auto add = [&](const std::vector<std::size_t>& front, const char* name) {
    if (contains(front, variant)) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  add(fronts.frame_ms, "run time");
  add(fronts.bytes, "size");
  add(fronts.bake_s, "bake");
  return text;
}

// ---- Stages ----

struct StageRow {
  StageFigures stage;
  std::vector<std::size_t> variants;
};

bool sameRun(const StageFigures& a, const StageFigures& b) {
  return a.stage == b.stage && a.wall_s == b.wall_s && a.cpu_s == b.cpu_s &&
         a.peak_memory_bytes == b.peak_memory_bytes && a.bytes == b.bytes && a.warnings == b.warnings;
}

// Runs that variants share stand once; in the order of the stages.
std::vector<StageRow> stageRows(const Plan& plan) {
  std::vector<StageRow> rows;
  std::vector<std::string> order;
  for (std::size_t v = 0; v < plan.variants.size(); ++v)
    for (const StageFigures& stage : plan.variants[v].stages) {
      if (std::find(order.begin(), order.end(), stage.stage) == order.end()) order.push_back(stage.stage);
      const auto known = std::find_if(rows.begin(), rows.end(),
                                      [&](const StageRow& row) { return sameRun(row.stage, stage); });
      if (known == rows.end())
        rows.push_back({stage, {v}});
      else
        known->variants.push_back(v);
    }
  std::stable_sort(rows.begin(), rows.end(), [&](const StageRow& a, const StageRow& b) {
    return std::find(order.begin(), order.end(), a.stage.stage) <
           std::find(order.begin(), order.end(), b.stage.stage);
  });
  return rows;
}

}  // namespace

std::string causesTable(const Plan& plan, const Evaluation& evaluation) {
  std::vector<std::string> causes;
  double largest = 0;
  for (const VariantFigures& variant : evaluation.variants)
    for (const CauseError& cause : variant.causes) {
      if (std::find(causes.begin(), causes.end(), cause.cause) == causes.end()) causes.push_back(cause.cause);
      largest = std::max(largest, cause.rel_rmse);
    }
  if (causes.empty()) return "";
  std::vector<Heading> headings = {{"variant", "", true}};
  for (const std::string& cause : causes) headings.push_back({spaced(cause), "%", true});
  std::string html =
      "<h2>Causes of the error</h2>\n<p>From the reference to the pack one cause is switched on at a time; a "
      "bar is the distance "
      "between two neighbouring pictures, relative RMSE in %. Distances are lengths: they do not add up to "
      "the error.</p>\n" +
      tableBegin(headings, "bars");
  for (std::size_t v = 0; v < plan.variants.size(); ++v) {
    html += "<tr>" + cell(escaped(plan.variants[v].name));
    for (const std::string& name : causes) {
      const auto& list = evaluation.variants[v].causes;
      const auto cause =
          std::find_if(list.begin(), list.end(), [&](const CauseError& c) { return c.cause == name; });
      if (cause == list.end()) {
        html += cell("–", "text");
        continue;
      }
      const double share = largest > 0 ? cause->rel_rmse / largest : 0;
      html += cell(numberText(100 * cause->rel_rmse) +
                       "<span class=\"bar\" style=\"width:" + coordinate(100 * share) + "%\"></span>",
                   "text");
    }
    html += "</tr>\n";
  }
  return html + kTableEnd;
}

std::string windowsTable(const Plan& plan, const Evaluation& evaluation) {
  std::string rows;
  for (std::size_t v = 0; v < plan.variants.size(); ++v)
    for (const auto& [light, choice] : evaluation.variants[v].windows) {
      rows += "<tr>" + cell(escaped(plan.variants[v].name)) + cell(escaped(light)) +
              cell(numberText(choice.lambda));
      for (const double error :
           {choice.without.displayed, choice.error.displayed, choice.without.radiance, choice.error.radiance})
        rows += cell(numberText(100 * error));
      rows += "</tr>\n";
    }
  if (rows.empty()) return "";
  return "<h2>Windows against ringing</h2>\n<p>Of each light: the strength λ with which what is shown errs "
         "least over its views.</p>\n" +
         tableBegin({{"variant", "", true},
                     {"light", "", true},
                     {"λ", "", true},
                     {"displayed, without", "%", true},
                     {"displayed, with", "%", true},
                     {"radiance, without", "%", true},
                     {"radiance, with", "%", true}}) +
         rows + kTableEnd;
}

std::string variantsTable(const Plan& plan, const Evaluation& evaluation) {
  const std::vector<Column> columns = variantColumns(plan, evaluation);
  std::vector<Heading> headings = {{"variant", "", true}};
  std::vector<std::optional<double>> least;
  for (const Column& column : columns) {
    headings.push_back(column.heading);
    least.push_back(leastOf(column, plan.variants.size()));
  }
  headings.push_back({"on the front of", "", true});
  std::string html =
      "<h2>All variants</h2>\n<p class=\"soft\">▾ marks the least of a column. Times: median, with its "
      "quartiles below.</p>\n" +
      tableBegin(headings);
  for (std::size_t v = 0; v < plan.variants.size(); ++v) {
    html += "<tr>" + cell(escaped(plan.variants[v].name));
    for (std::size_t c = 0; c < columns.size(); ++c) html += variantCell(columns[c], v, least[c]);
    html += cell(frontsOf(evaluation.fronts, v), "text") + "</tr>\n";
  }
  return html + kTableEnd;
}

std::string storageTable(const Plan& plan, const Evaluation& evaluation) {
  if (!evaluation.storage) return "";
  const StorageFigures& storage = *evaluation.storage;
  std::vector<Heading> headings = {{"method", "", true},
                                   {"bytes", "% of dense"},
                                   {"operations", "% of rows’"},
                                   {"product", "CPU, ms"},
                                   {"L*", "rms over lights, %"}};
  for (const PlanView& view : plan.views) headings.push_back({view.name, "picture, %"});
  std::string html =
      "<h2>Storage of the transfer matrix</h2>\n<p>Ways to store the same matrix at about the bytes of its "
      "exact sums, and at "
      "shares of them; their tables are coded by the same entropy coder. L*: relative RMS of the light that "
      "falls on "
      "the cells, from that of exact rows. Pictures: relative RMSE from the reference; what exact sums have "
      "there "
      "is not storage’s.</p>\n" +
      tableBegin(headings);
  for (const StorageMethod& method : storage.methods) {
    html +=
        "<tr>" +
        cell(escaped(spaced(method.name)) + "<span class=\"range\">" + escaped(method.parameters) +
             "</span>") +
        cell(
            bytesText(method.bytes) + "<span class=\"range\">" +
            numberText(100.0 * static_cast<double>(method.bytes) / static_cast<double>(storage.dense_bytes)) +
            "</span>") +
        cell(numberText(50.0 * static_cast<double>(method.operations) /
                        static_cast<double>(std::max<std::uint64_t>(storage.entries, 1)))) +
        cell(numberText(method.product_ms.median) + range(method.product_ms.low, method.product_ms.high)) +
        cell(hundredfoldText(rootMeanSquare(method.incident_errors)));
    for (const double error : method.picture_errors) html += cell(hundredfoldText(error));
    html += "</tr>\n";
  }
  return html + kTableEnd;
}

std::string leftOutTable(const Plan& plan, const Evaluation& evaluation, const Varied& varied) {
  struct Row {
    LeftOut left_out;
    std::optional<double> measured;
    std::vector<std::size_t> variants;
  };
  std::vector<Row> rows;
  for (std::size_t v = 0; v < plan.variants.size(); ++v)
    for (const LeftOut& item : plan.variants[v].left_out) {
      const std::optional<double> measured = evaluation.variants[v].leftOutError();
      const auto known = std::find_if(rows.begin(), rows.end(), [&](const Row& row) {
        const LeftOut& other = row.left_out;
        return other.stage == item.stage && other.what == item.what && other.figure == item.figure &&
               other.value == item.value && other.threshold == item.threshold && other.error == item.error &&
               row.measured == measured;
      });
      if (known == rows.end())
        rows.push_back({item, measured, {v}});
      else
        known->variants.push_back(v);
    }
  std::string html = "<h2>What was left out</h2>\n";
  if (rows.empty())
    return html + "<p>Nothing: no variant had a stage that a measured figure made unnecessary.</p>\n";
  html +=
      "<p>A measured figure stayed at or below its threshold, so this was not computed. <i>Expected</i> is "
      "what the figure says of the error that "
      "it adds, <i>measured</i> what the pictures say of all omissions of a variant together.</p>\n" +
      tableBegin({{"what", "", true},
                  {"stage", "", true},
                  {"by the figure", "", true},
                  {"value", ""},
                  {"threshold", ""},
                  {"expected", "error, %"},
                  {"measured", "error, %"},
                  {"variants", "", true}});
  for (const Row& row : rows)
    html += "<tr>" + cell(escaped(row.left_out.what)) + cell(escaped(row.left_out.stage), "text") +
            cell("<code>" + escaped(row.left_out.figure) + "</code>", "text") +
            cell(numberText(row.left_out.value)) + cell(numberText(row.left_out.threshold)) +
            cell(row.left_out.error ? numberText(100 * *row.left_out.error) : "–") +
            cell(row.measured ? numberText(100 * *row.measured) : "–") +
            cell(escaped(groupText(plan, varied, row.variants)), "text wrap") + "</tr>\n";
  return html + kTableEnd;
}

std::string stagesTable(const Plan& plan, const Varied& varied) {
  const std::vector<StageRow> rows = stageRows(plan);
  if (rows.empty()) return "";
  std::string html =
      "<h2>Stages</h2>\n<p>What it took to bake; a run that several variants share stands once.</p>\n" +
      tableBegin({{"stage", "", true},
                  {"variants", "", true},
                  {"wall", "s"},
                  {"CPU", "s"},
                  {"memory", "peak"},
                  {"outputs", "size"},
                  {"warnings", "", true}});
  for (const StageRow& row : rows) {
    std::string warnings;
    for (const std::string& warning : row.stage.warnings)
      warnings += (warnings.empty() ? "" : "<br>") + escaped(warning);
    html += "<tr>" + cell(escaped(row.stage.stage)) +
            cell(escaped(groupText(plan, varied, row.variants)), "text wrap") +
            cell(numberText(row.stage.wall_s)) + cell(numberText(row.stage.cpu_s)) +
            cell(bytesText(row.stage.peak_memory_bytes)) + cell(bytesText(row.stage.bytes)) +
            cell(warnings, "text wrap") + "</tr>\n";
  }
  return html + kTableEnd;
}

std::string failedTable(const Plan& plan) {
  if (plan.failed.empty()) return "";
  std::string html = "<h2>Failed variants</h2>\n" +
                     tableBegin({{"variant", "", true}, {"stage", "", true}, {"reason", "", true}});
  for (const FailedVariant& failed : plan.failed)
    html += "<tr>" + cell(escaped(failed.name)) + cell(escaped(failed.stage), "text") +
            cell(escaped(failed.reason), "text wrap") + "</tr>\n";
  return html + kTableEnd;
}

std::string definitions(const Plan& plan, const Evaluation& evaluation) {
  std::string html = R"(<h2>What the figures mean</h2>
<dl class="terms">
<dt>error (relative RMSE)</dt><dd>√(mean |Δ|² − mean variance of the reference) ÷ √(mean |reference|²), over the red, green and blue linear radiance of
pixels that both pictures cover wholly. The noise of the path-traced reference is subtracted, as it would count as error. Over several views: root of the mean square.</dd>
<dt>p99</dt><dd>99th percentile over pixels of |Δ| (rms over colours) ÷ rms of the view’s reference, pooled over views. Noise is not subtracted.</dd>
<dt>FLIP</dt><dd>How different two pictures look to someone who flips between them, 0 to 1 (Andersson et al. 2020), on display-encoded pictures at the player’s exposure, 67 pixels a
degree; mean over pixels where either picture shows something.</dd>
<dt>coverage error</dt><dd>mean |Δ alpha| ÷ mean alpha of the reference: what the silhouette costs. Mean over views.</dd>
<dt>frame, CPU</dt><dd>Light change + view change, all vertices, on all threads; medians over rounds that go through all variants in turn. Light change: turning the light, diffuse
vectors, transferred radiance. View change: rows of the eye times transferred radiance.</dd>
<dt>OpenGL</dt><dd>What the player measured: its passes at a light change, and a frame with everything drawn but not read back, until OpenGL had finished.</dd>
<dt>GPU</dt><dd>The same by the GPU’s own clock.</dd>
<dt>bake</dt><dd>Wall and CPU seconds of all stages that the pack needs, each when it last ran.</dd>
<dt>Pareto front</dt><dd>Variants that no other one beats or equals in both error and cost while being better in one.</dd>
</dl>
)";
  html += "<h3>Noise of the references</h3>\n" + tableBegin({{"view", "", true},
                                                             {"light", "", true},
                                                             {"camera", "", true},
                                                             {"standard error", "% of its rms"}});
  for (std::size_t view = 0; view < plan.views.size(); ++view)
    html += "<tr>" + cell(escaped(plan.views[view].name)) + cell(escaped(plan.views[view].light), "text") +
            cell(escaped(plan.views[view].camera), "text") + cell(numberText(100 * evaluation.noise[view])) +
            "</tr>\n";
  return html + kTableEnd;
}

}  // namespace bakelight::report
