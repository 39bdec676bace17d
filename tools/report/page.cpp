#include "tools/report/page.h"

#include <cmath>
#include <functional>

#include "tools/report/page_style.h"
#include "tools/report/page_tables.h"
#include "tools/report/plot.h"
#include "tools/report/text.h"
#include "tools/report/varied.h"

namespace bakelight::report {
namespace {

std::string counted(std::size_t count, const std::string& singular, const std::string& plural) {
  return std::to_string(count) + ' ' + (count == 1 ? singular : plural);
}

// ---- Head ----

std::string card(const std::string& role, const PlanVariant& variant, const VariantFigures& figures) {
  return "<div class=\"card\"><div class=\"role\">" + escaped(role) + "</div><div class=\"name\">" +
         escaped(variant.name) + "</div><dl><dt>error</dt><dd>" + percentText(figures.errors.rel_rmse) +
         "</dd><dt>frame</dt><dd>" + numberText(figures.frame_ms()) + " ms</dd><dt>pack</dt><dd>" +
         bytesText(figures.bytes) + "</dd><dt>bake</dt><dd>" + numberText(figures.bake_s) +
         " s</dd></dl></div>\n";
}

std::string head(const Plan& plan, const Evaluation& evaluation, const Thumbnails& thumbnails) {
  std::string html = "<h1>" + escaped(plan.asset) + ": error against run time</h1>\n<p class=\"soft\">" +
                     counted(plan.variants.size(), "variant", "variants") +
                     " against path-traced references in " + counted(plan.views.size(), "view", "views") +
                     "; " + std::to_string(evaluation.fronts.frame_ms.size()) +
                     " on the front of error against milliseconds a frame" +
                     (plan.failed.empty() ? "" : "; " + std::to_string(plan.failed.size()) + " failed") +
                     ".</p>\n<div class=\"cards\">\n";
  for (const ShownVariant& shown : thumbnails.shown)
    html += card(shown.role, plan.variants[shown.variant], evaluation.variants[shown.variant]);
  return html + "</div>\n";
}

// ---- Plots ----

// The cost of a variant with its spread.
using Cost = std::function<Spread(const VariantFigures&)>;

std::string titleOf(const PlanVariant& variant, const VariantFigures& figures) {
  return variant.name + "\nerror " + percentText(figures.errors.rel_rmse) + "\nframe " +
         numberText(figures.frame_ms()) + " ms\npack " + bytesText(figures.bytes) + "\nbake " +
         numberText(figures.bake_s) + " s";
}

std::string figure(const Plan& plan, const Evaluation& evaluation, const Varied& varied, Plot plot,
                   const Cost& cost) {
  plot.error_label = "error: relative RMSE, %";
  plot.error_text = [](double error) { return tickText(100 * error); };
  for (std::size_t v = 0; v < plan.variants.size(); ++v) {
    const VariantFigures& figures = evaluation.variants[v];
    const Spread spread = cost(figures);
    const std::size_t marker = varied.hasShown() ? varied.parameters[varied.shown].value_of[v] : 0;
    plot.points.push_back({plan.variants[v].name, shortLabel(plan, varied, v),
                           titleOf(plan.variants[v], figures), spread.median, figures.errors.rel_rmse,
                           spread.low, spread.high, marker});
  }
  return "<figure><figcaption>" + escaped(plot.title) + "</figcaption>" + plotSvg(plot) + "</figure>\n";
}

std::string legend(const Varied& varied) {
  const auto entry = [](std::size_t marker, bool filled, const std::string& text) {
    return "<li><svg class=\"g" + std::to_string(marker) +
           "\" viewBox=\"-7 -7 14 14\" aria-hidden=\"true\">" + markerSvg(marker, 0, 0, filled) + "</svg>" +
           escaped(text) + "</li>";
  };
  std::string html;
  if (varied.hasShown()) {
    const VariedParameter& shown = varied.parameters[varied.shown];
    html += "<ul class=\"legend\"><li><b>" + escaped(shown.name) + "</b></li>";
    for (std::size_t value = 0; value < shown.values.size(); ++value)
      html += entry(value, true, shown.values[value]);
    html += "</ul>";
  }
  std::string labels;
  for (const std::size_t p : labelParameters(varied))
    labels += (labels.empty() ? "" : " · ") + varied.parameters[p].name;
  html +=
      "<p class=\"soft\">Filled: on the Pareto front, the dashed line; nothing is both cheaper and nearer to "
      "the reference. Hollow: beaten." +
      (labels.empty() ? "" : " Labels: " + escaped(labels) + ".") + " Both axes are logarithmic.</p>\n";
  return html;
}

Spread exactly(double value) {
  return {value, value, value};
}

std::string plots(const Plan& plan, const Evaluation& evaluation, const Varied& varied) {
  std::string html = "<h2>Error against cost</h2>\n" + legend(varied) + "<div class=\"plots\">\n";
  html += figure(plan, evaluation, varied,
                 {"Run time",
                  "ms a frame on the CPU: light change + view change",
                  "",
                  tickText,
                  {},
                  {},
                  evaluation.fronts.frame_ms},
                 [](const VariantFigures& v) {
                   return Spread{v.frame_ms(), v.light_change_ms.low + v.view_change_ms.low,
                                 v.light_change_ms.high + v.view_change_ms.high};
                 });
  html += figure(plan, evaluation, varied,
                 {"Size", "size of the pack", "", bytesTickText, {}, {}, evaluation.fronts.bytes},
                 [](const VariantFigures& v) { return exactly(static_cast<double>(v.bytes)); });
  html += figure(plan, evaluation, varied,
                 {"Bake time",
                  "bake, s: all stages that the pack needs",
                  "",
                  tickText,
                  {},
                  {},
                  evaluation.fronts.bake_s},
                 [](const VariantFigures& v) { return exactly(v.bake_s); });
  return html + "</div>\n";
}

// ---- Pictures ----

std::string image(const std::string& uri, const Thumbnails::View& view, const std::string& alternative) {
  return "<img src=\"" + uri + "\" width=\"" + std::to_string(view.width_px) + "\" height=\"" +
         std::to_string(view.height_px) + "\" alt=\"" + escaped(alternative) + "\">";
}

// The colours' legend, an SVG.
std::string differenceScale(double end) {
  constexpr int kStops = 32, kTicks = 4;
  constexpr double kWidth = 240, kMargin = 18;
  std::string svg = "<svg class=\"scale\" viewBox=\"0 0 " + coordinate(kWidth + 2 * kMargin) +
                    " 30\" role=\"img\" aria-label=\"colours of differences\">";
  for (int stop = 0; stop < kStops; ++stop) {
    const auto color = differenceColor((stop + 0.5) / kStops);
    std::string channels;
    for (const float channel : color)
      channels += (channels.empty() ? "" : " ") + std::to_string(std::lround(255 * channel));
    svg += "<rect x=\"" + coordinate(kMargin + kWidth * stop / kStops) + "\" y=\"2\" width=\"" +
           coordinate(kWidth / kStops + 0.3) + "\" height=\"11\" fill=\"rgb(" + channels + ")\"/>";
  }
  for (int tick = 0; tick <= kTicks; ++tick) {
    const double position = static_cast<double>(tick) / kTicks;
    svg += "<text class=\"tick\" text-anchor=\"middle\" x=\"" + coordinate(kMargin + kWidth * position) +
           "\" y=\"26\">" + (tick == kTicks ? "≥ " : "") + tickText(100 * end * differenceAt(position)) +
           "</text>";
  }
  return "<p class=\"soft\">Below each picture: its difference from the reference, in % of the reference’s "
         "rms.</p>\n" +
         svg + "</svg>\n";
}

std::string pictures(const Plan& plan, const Evaluation& evaluation, const Thumbnails& thumbnails) {
  std::string html =
      "<h2>Pictures</h2>\n" + differenceScale(thumbnails.difference_end) + "<div class=\"views\">\n";
  for (std::size_t v = 0; v < plan.views.size(); ++v) {
    const Thumbnails::View& view = thumbnails.views[v];
    const std::string& name = plan.views[v].name;
    html += "<div class=\"view\"><h3>" + escaped(name) +
            "</h3><div class=\"pictures\" style=\"--n:" + std::to_string(1 + thumbnails.shown.size()) +
            "\">\n<figure>" + image(view.reference, view, "reference, " + name) +
            "<figcaption><span class=\"name\">reference</span>path-traced, standard error " +
            percentText(evaluation.noise[v]) + "</figcaption></figure>\n";
    for (std::size_t i = 0; i < thumbnails.shown.size(); ++i) {
      const std::size_t variant = thumbnails.shown[i].variant;
      const ErrorFigures& errors = evaluation.variants[variant].view_errors[v];
      const std::string& variant_name = plan.variants[variant].name;
      html += "<figure>" + image(view.pictures[i], view, variant_name + ", " + name) +
              image(view.differences[i], view, "difference of " + variant_name + " from the reference") +
              "<figcaption><span class=\"name\">" + escaped(variant_name) + "</span>" +
              escaped(thumbnails.shown[i].role) + "; error " + percentText(errors.rel_rmse) + ", FLIP " +
              numberText(errors.flip) + "</figcaption></figure>\n";
    }
    html += "</div></div>\n";
  }
  return html + "</div>\n";
}

}  // namespace

std::string pageHtml(const Plan& plan, const Evaluation& evaluation, const Thumbnails& thumbnails) {
  const Varied varied = variedParameters(plan, kMarkers);
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
         "<meta name=\"color-scheme\" content=\"light dark\">\n<title>" +
         escaped(plan.asset) + ": error against run time</title>\n<style>" + pageStyle() +
         "</style>\n</head>\n<body>\n" + head(plan, evaluation, thumbnails) +
         plots(plan, evaluation, varied) + pictures(plan, evaluation, thumbnails) +
         causesTable(plan, evaluation) + windowsTable(plan, evaluation) + variantsTable(plan, evaluation) +
         storageTable(plan, evaluation) + leftOutTable(plan, evaluation, varied) + stagesTable(plan, varied) +
         failedTable(plan) + definitions(plan, evaluation) + "</body>\n</html>\n";
}

}  // namespace bakelight::report
