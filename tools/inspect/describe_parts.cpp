#include "tools/inspect/describe_parts.h"

#include <array>
#include <charconv>
#include <numeric>
#include <string_view>

#include "tools/inspect/tensor_figures.h"

namespace bakelight::inspect {

using formats::Json;

Json numberOf(float value) {
  std::array<char, 32> text{};
  const auto [end, status] = std::to_chars(text.data(), text.data() + text.size(), value);
  return Json::parse(std::string_view(text.data(), end));
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
