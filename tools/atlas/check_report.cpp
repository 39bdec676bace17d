#include "tools/atlas/check_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace bakelight::atlas {

std::vector<std::pair<std::string, formats::Json>> figuresOf(const AtlasFigures& figures) {
  return {{"charts", figures.charts},
          {"triangles", figures.triangles},
          {"mirrored_charts", figures.mirrored_charts},
          {"flipped", figures.flipped},
          {"collapsed", figures.collapsed},
          {"overlapping_texels", figures.overlapping_texels},
          {"crossing_edges", figures.crossing_edges},
          {"outside", figures.outside},
          {"resolution", figures.resolution},
          {"smallest_gutter", figures.smallest_gutter},
          {"utilisation", figures.utilisation},
          {"touched", figures.touched},
          {"triangles_below_texel", figures.triangles_below_texel},
          {"triangles_without_texel", figures.triangles_without_texel},
          {"l2_stretch", figures.l2_stretch},
          {"l_infinity_stretch", figures.l_infinity_stretch},
          {"mean_anisotropy", figures.mean_anisotropy},
          {"worst_chart_l2", figures.worst_chart_l2},
          {"texel_density_spread", figures.texel_density_spread},
          {"border_length", figures.border_length}};
}

CheckReport reportOf(const formats::TriangleMesh& mesh, int resolution, int gutter, const std::string& file) {
  CheckReport report;
  const bool has_texcoords = !mesh.texcoords.empty();
  if (has_texcoords) {
    const AtlasFigures figures = check(atlasOf(mesh), resolution, file);
    report.figures = figuresOf(figures);
    report.defects = figures.defects();
    report.gutter_shortfall = std::max(0, gutter - figures.smallest_gutter);
  } else {
    report.figures = {{"triangles", mesh.triangleCount()}};
    report.defects = static_cast<std::int64_t>(mesh.triangleCount());
    report.gutter_shortfall = gutter;
  }
  report.figures.insert(report.figures.begin(), {"has_texcoords", has_texcoords});
  report.figures.insert(report.figures.end(), {{"defects", report.defects},
                                               {"gutter_shortfall", report.gutter_shortfall},
                                               {"shortcomings", report.defects + report.gutter_shortfall}});
  return report;
}

std::string asText(const CheckReport& report) {
  constexpr std::size_t kNameWidth = 26;
  std::string text;
  for (const auto& [name, value] : report.figures) {
    std::string words = name;
    std::replace(words.begin(), words.end(), '_', ' ');
    const std::string shown =
        value.is_number_float() ? fmt::format("{:g}", value.get<double>()) : value.dump();
    words.resize(kNameWidth, ' ');
    text.append(words).append(shown).append("\n");
  }
  return text;
}

}  // namespace bakelight::atlas
