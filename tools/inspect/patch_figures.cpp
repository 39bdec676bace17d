#include "tools/inspect/patch_figures.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "tools/inspect/describe.h"
#include "tools/inspect/direction_strokes.h"
#include "tools/inspect/patch_preview.h"

namespace bakelight::inspect {

std::vector<Section> describeMesoMesh(const formats::MesoMesh& meso) {
  std::vector<Section> sections = describeMesh(meso.mesh, {});
  int turns = 0;
  const std::vector<TurningTriangle> turning = turningTriangles(meso);
  for (const TurningTriangle& singular : turning) turns += singular.index;
  sections.push_back({"directions",
                      {{"symmetry", meso.symmetry, ""},
                       {"singularities", turning.size(), ""},
                       {"index_sum", static_cast<double>(turns) / meso.symmetry, ""}},
                      {},
                      {}});
  const std::vector<float> coherence = coherenceOf(meso);
  double sum = 0;
  for (const float share : coherence) sum += share;
  const std::set<formats::Float2> places(meso.patch.begin(), meso.patch.end());
  sections.push_back(
      {"patch",
       {{"places", places.size(), ""},
        {"coherent_share",
         coherence.empty() ? formats::Json() : formats::Json(sum / static_cast<double>(coherence.size())),
         ""}},
       {},
       {}});
  return sections;
}

std::vector<Section> describeIdMap(const formats::IndexImage& ids) {
  enum : std::size_t { kMaterial = 2, kVertex, kCoverage };
  std::uint64_t covered = 0;
  std::map<std::uint32_t, std::uint64_t> texels;  // by material
  std::set<std::array<std::uint32_t, 2>> places;
  std::vector<std::uint32_t> vertices;
  for (std::size_t t = 0; t < ids.values.size(); t += ids.channelCount()) {
    const std::uint32_t* id = &ids.values[t];
    if (id[kCoverage] == 0) continue;
    ++covered;
    ++texels[id[kMaterial]];
    places.insert({id[0], id[1]});
    vertices.push_back(id[kVertex]);
  }
  std::sort(vertices.begin(), vertices.end());
  const auto taken = std::unique(vertices.begin(), vertices.end()) - vertices.begin();
  std::vector<Section> sections = {{"size",
                                    {{"width_px", ids.width, "px"},
                                     {"height_px", ids.height, "px"},
                                     {"covered_texels", covered, ""},
                                     {"meso_vertices", taken, ""},
                                     {"places", places.size(), ""}},
                                    {},
                                    {}}};
  Section materials{"materials", {}, {"material", "texels"}, {}};
  for (const auto& [material, count] : texels) materials.rows.push_back({material, count});
  sections.push_back(std::move(materials));
  return sections;
}

}  // namespace bakelight::inspect
