#include "tools/player/techniques/technique.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "formats/error.h"
#include "tools/player/techniques/all_frequency.h"
#include "tools/player/techniques/bi_scale.h"
#include "tools/player/techniques/translucent.h"
#include "tools/player/techniques/vertex_radiance.h"

namespace bakelight::player {

void Technique::setCubeLight(std::span<const formats::Float3>) {
  throw std::logic_error("this technique takes no cube map of light");
}

void Technique::setPunctualLights(std::span<const transport::PlacedPunctualLight> lights) {
  if (!lights.empty()) throw std::logic_error("punctual lights cannot fall on what this technique plays");
}

std::vector<PlayedTechnique>& techniques() {
  static std::vector<PlayedTechnique> techniques = {
      {"vertices", VertexRadiance::plays, VertexRadiance::needs,
       [](const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light) -> std::unique_ptr<Technique> {
         return std::make_unique<VertexRadiance>(pack, mesh, near_light);
       }},
      {"bi-scale", BiScale::plays, BiScale::needs,
       [](const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light) -> std::unique_ptr<Technique> {
         return std::make_unique<BiScale>(pack, mesh, near_light);
       }},
      {"all-frequency", AllFrequency::plays, AllFrequency::needs,
       [](const formats::Pack& pack, const SurfaceMesh& mesh, bool) -> std::unique_ptr<Technique> {
         return std::make_unique<AllFrequency>(pack, mesh);
       }},
      {"translucent", Translucent::plays, Translucent::needs,
       [](const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light) -> std::unique_ptr<Technique> {
         return std::make_unique<Translucent>(pack, mesh, near_light);
       }},
  };
  return techniques;
}

const PlayedTechnique& techniqueFor(const formats::Pack& pack) {
  const std::vector<PlayedTechnique>& known = techniques();
  const auto found = std::find_if(known.rbegin(), known.rend(),
                                  [&](const PlayedTechnique& technique) { return technique.plays(pack); });
  if (found != known.rend()) return *found;
  std::string names;
  for (const PlayedTechnique& technique : known)
    names += (names.empty() ? "" : ", ") + std::string(technique.name);
  throw badInput({"", "pack", ""},
                 std::string("no technique of this player plays transfer \"") + pack.transfer.kind() +
                     "\" with reflection \"" + pack.appearances.front().reflection.kind() + '"',
                 "a pack for one of its techniques: " + names, "a player that has the technique");
}

}  // namespace bakelight::player
