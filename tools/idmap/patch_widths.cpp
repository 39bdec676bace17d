#include "tools/idmap/patch_widths.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "transport/vector_types.h"

namespace bakelight::idmap {

using transport::Vec3;

std::map<std::string, double> patchWidths(const formats::MesoMesh& meso) {
  // Farther apart, places belong to two pieces of the patch, or the change has wrapped around it.
  constexpr double kMostChange = 0.25, kAlong = 0.9;
  const std::vector<std::string>& names = meso.mesh.material_names;
  std::vector<std::vector<double>> widths(std::max<std::size_t>(1, names.size()));
  for (const formats::Triangle& triangle : meso.mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      if (meso.materials[a] != meso.materials[b]) continue;
      const Vec3 edge = transport::vec3(meso.mesh.positions[b]) - transport::vec3(meso.mesh.positions[a]);
      const double along = edge.dot(transport::vec3(meso.tangents[a]));
      double change = double{meso.patch[b][0]} - meso.patch[a][0];
      change -= std::round(change);
      if (std::abs(along) < kAlong * edge.norm() || std::abs(change) > kMostChange || change * along <= 0)
        continue;
      widths[meso.materials[a]].push_back(along / change);
    }
  std::map<std::string, double> result;
  for (std::size_t m = 0; m < widths.size(); ++m) {
    if (widths[m].empty()) continue;
    const auto middle = widths[m].begin() + static_cast<std::ptrdiff_t>(widths[m].size() / 2);
    std::nth_element(widths[m].begin(), middle, widths[m].end());
    result[names.empty() ? "" : names[m]] = *middle;
  }
  return result;
}

}  // namespace bakelight::idmap
