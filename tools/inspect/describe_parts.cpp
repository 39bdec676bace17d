#include "tools/inspect/describe_parts.h"

#include <numeric>

#include "tools/inspect/tensor_figures.h"

namespace bakelight::inspect {

using formats::Json;

Json numberOf(float value) {
  return Json::parse(Json(value).dump());
}

Json listOf(const formats::Float3& v) {
  Json list = Json::array();
  for (const float element : v) list.push_back(numberOf(element));
  return list;
}

Section bandSection(const std::string& name, std::span<const float> vectors, int order) {
  const std::vector<double> energies = bandEnergies(vectors, order);
  const double total = std::accumulate(energies.begin(), energies.end(), 0.0);
  Section section{name, {}, {"band", "mean_energy", "share_percent"}, {}};
  for (std::size_t l = 0; l < energies.size(); ++l)
    section.rows.push_back({l, energies[l], total > 0 ? 100 * energies[l] / total : 0.0});
  return section;
}

}  // namespace bakelight::inspect
