#include "tools/player/techniques/technique.h"

#include <algorithm>
#include <string>

#include "formats/error.h"
#include "tools/player/techniques/bi_scale.h"
#include "tools/player/techniques/vertex_radiance.h"

namespace bakelight::player {

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
