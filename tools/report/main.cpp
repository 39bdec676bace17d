// report: error against run time of the variants of an asset.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/file.h"
#include "formats/json.h"
#include "tools/report/evaluation.h"
#include "tools/report/page.h"
#include "tools/report/plan.h"
#include "tools/report/report_json.h"
#include "tools/stage/stage.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path plan_path, report_path, page_path;
  int rounds = 25;
  bool storage = true;

  stage::Tool tool("report",
                   "Compares the variants of an asset with their references: error against run time.");
  tool.input("plan", "report_plan", plan_path,
             "JSON: views with references, variants with packs (docs/REPORT.md)")
      .output("report", "report", report_path, "JSON with all figures")
      .output("page", "page", page_path, "the same as one self-contained HTML page, with plots and pictures",
              false)
      .parameter("rounds", rounds, {1, 10000}, "",
                 "Times are medians over so many rounds through all variants")
      .parameter("storage", storage,
                 "Of transfer in a pixel basis: compare other ways to store it, at as many bytes");

  return tool.run(argc, argv, [&](stage::Run& run) {
    const report::Plan plan = report::planFromJson(formats::readJson(plan_path), plan_path.string());
    const report::Sources sources = report::fileSources();
    stage::Progress progress = run.progress("report", 2 * plan.variants.size(), "evaluations");
    report::Evaluator evaluator(plan, sources);
    const report::Evaluation evaluation = evaluator.evaluate(
        rounds, [&] { progress.advance(); }, storage);
    formats::writeJson(report_path, report::reportJson(plan, evaluation));
    if (!page_path.empty()) {
      const report::Thumbnails thumbnails = report::makeThumbnails(plan, evaluation, evaluator);
      formats::writeFileAtomically(page_path, report::pageHtml(plan, evaluation, thumbnails));
    }
    run.stat("variants", plan.variants.size());
    run.stat("views", plan.views.size());
    run.stat("failed", plan.failed.size());
  });
}
