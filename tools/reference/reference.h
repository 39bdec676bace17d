// The path-traced picture of a mesh and its material: what the player would show if nothing were
// approximated.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "formats/frame_settings.h"
#include "formats/light_rig.h"
#include "formats/words.h"
#include "tools/reference/pictures.h"
#include "tools/stage/stage.h"

namespace bakelight::reference {

enum class At { kPixels, kVertices, kLeastSquares };
inline constexpr formats::Word<At> kAts[] = {
    {"pixels", At::kPixels}, {"vertices", At::kVertices}, {"least_squares", At::kLeastSquares}};

// What stands on faces whose material has a patch with a surface.
enum class Patches { kGeometry, kNone };
inline constexpr formats::Word<Patches> kPatches[] = {{"geometry", Patches::kGeometry},
                                                      {"none", Patches::kNone}};

struct Options {
  formats::FrameSettings frame;
  PathOptions paths;
  At at = At::kPixels;
  Effort effort;
  int seed = 0;
  std::optional<GroundOptions> ground = {};  // with At::kPixels
};

// Throws Error(kBadInput) at /ground for a ground at vertices. `bounds` as in Scene: nothing, the mesh's own.
struct Reference {
  Picture picture;
  std::map<std::string, std::string> metadata;  // all that it takes to make it again
};
Reference makeReference(const Surface& surface, const formats::LightRig& rig, const Options& options,
                        const std::optional<transport::BoundingSphere>& bounds,
                        stage::ProgressStyle progress);

// The bounding sphere that a picture of makeReference was framed by, from its metadata. Throws
// Error(kBadInput) naming `file` if it is not there.
transport::BoundingSphere boundsFromMetadata(const std::map<std::string, std::string>& metadata,
                                             const std::string& file);

void reportStats(stage::Run& run, const Picture& picture, const Options& options);

}  // namespace bakelight::reference
