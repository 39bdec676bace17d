// The player's inputs and parameters.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "formats/pack.h"
#include "tools/player/headless.h"
#include "tools/stage/stage.h"
#include "transport/bi_scale_comparison.h"
#include "transport/frame.h"
#include "transport/lighting.h"
#include "transport/translucent_shading.h"

namespace bakelight::player {

enum class ShownReceiver { kNone, kSphere, kMesh };
inline constexpr formats::Word<ShownReceiver> kShownReceivers[] = {
    {"none", ShownReceiver::kNone}, {"sphere", ShownReceiver::kSphere}, {"mesh", ShownReceiver::kMesh}};

struct Options {
  std::filesystem::path pack_path, environment_path, lights_path, image_path;
  formats::FrameSettings settings;
  std::optional<double> windowing;  // none: as the rig says
  int cube_resolution = 64;
  transport::BiScaleEffects effects = transport::BiScaleEffects::kAll;
  transport::TranslucentResponse::Branches branches = transport::TranslucentResponse::Branches::kBoth;
  SurroundingsOptions surroundings;
  ShownReceiver receiver = ShownReceiver::kNone;
  transport::Receiver receiver_options;
  std::filesystem::path receiver_path;
};

// `options` outlives the tool's run.
void declareOptions(stage::Tool& tool, Options& options);

// Completed by the receiver, which is read if it is a mesh. Throws Error(kBadInput) if the pack has no volume for it, or the mesh no normals.
SurroundingsOptions surroundingsFor(const Options& options, const formats::Pack& pack);

void reportStats(stage::Run& run, const formats::Pack& pack, const transport::Lighting& lighting,
                 const HeadlessPicture& picture);

}  // namespace bakelight::player
