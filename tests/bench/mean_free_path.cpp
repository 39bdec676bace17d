// mean_free_path [PAGE.html]: error of a translucent plate as it is played against the integral that it stands for, by the medium's mean free path, from a
// hundredth of a texel to ten times the plate; as a table, and as a page with the plot of docs/TRANSLUCENCY.md.
#include <array>
#include <cmath>
#include <iostream>
#include <string>

#include "formats/error.h"
#include "formats/file.h"
#include "tests/bench/translucency_error.h"
#include "tests/support/plate.h"
#include "tools/report/page_style.h"
#include "tools/report/plot.h"
#include "tools/report/text.h"

namespace bakelight::bench {
namespace {

constexpr int kTexels = 96;
constexpr double kSpacing = 4.4, kAlbedo = 0.99;
constexpr double kPaths[] = {0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000};  // texels
constexpr std::size_t kReceivers = 2000, kLights = 3;

report::Plot plotOfErrors() {
  const formats::TriangleMesh mesh = tests::plateMesh(kTexels, kSpacing);
  const tests::TemporaryFolder folder;
  tests::writeMaps(mesh, kTexels, folder / "maps.exr");
  const kernels::Knots knots = kernels::knotsOf(mesh);
  const kernels::Texels texels = kernels::texelsOf(folder / "maps.exr", mesh, knots);
  report::Plot plot;
  plot.title = "Error by mean free path";
  plot.cost_label = "mean free path, texels";
  plot.error_label = "relative RMSE, %";
  plot.cost_text = report::tickText;
  plot.error_text = [](double error) { return report::tickText(100 * error); };
  std::cout << "path, texels  light         both    naive\n";
  for (const double path : kPaths) {
    const formats::Medium medium = tests::mediumOf(path, kAlbedo);
    const kernels::Made made =
        kernels::makeTranslucency(mesh, folder / "maps.exr", medium, {}, stage::ProgressStyle::kNone);
    const transport::MediumField field(medium, mesh.positions);
    const kernels::Reflectance reflectance(field, 2 * kTexels, 1, 1);
    std::size_t marker = 0;
    for (const auto& [name, light] : testLights(knots)) {
      const TranslucencyErrors errors =
          translucencyErrors(knots, texels, reflectance, made.translucency, light, kReceivers);
      std::cout << report::numberText(path) << "\t" << name << "\t" << report::percentText(errors.blend)
                << "\t" << report::percentText(errors.naive) << std::endl;
      plot.points.push_back({name, "", name, path, errors.blend, path, path, marker});
      plot.points.push_back(
          {name + ", naive", "", name + ", naive", path, errors.naive, path, path, kLights + marker});
      ++marker;
    }
  }
  return plot;
}

std::string pageOf(const report::Plot& plot) {
  std::array<std::string, 2 * kLights> names;
  for (const report::PlotPoint& point : plot.points) names[point.marker] = point.name;
  std::string legend;
  for (std::size_t marker = 0; marker < names.size(); ++marker)
    legend += "<li><svg class=\"g" + std::to_string(marker) + "\" viewBox=\"-7 -7 14 14\">" +
              report::markerSvg(marker, 0, 0, false) + "</svg>" + names[marker] + "</li>";
  return "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>" + plot.title +
         "</title><style>" + report::pageStyle() + "</style></head><body><ul class=\"legend\">" + legend +
         "</ul>" + report::plotSvg(plot) + "</body></html>\n";
}

}  // namespace
}  // namespace bakelight::bench

int main(int argc, char** argv) {
  using namespace bakelight;
  try {
    const report::Plot plot = bench::plotOfErrors();
    if (argc > 1) formats::writeFileAtomically(argv[1], bench::pageOf(plot));
  } catch (const Error& error) {
    std::cerr << "mean_free_path: " << error.paragraph() << '\n';
    return static_cast<int>(error.status());
  }
}
