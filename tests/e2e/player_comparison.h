// The player's picture against one made on the CPU from the same pack, light and camera.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "transport/frame.h"
#include "transport/receiver.h"

namespace bakelight::tests {

struct PlayerComparison {
  std::size_t pixels = 0;             // of the picture
  std::size_t object_pixels = 0;      // compared, and see the object in every subsample
  std::size_t emitter_pixels = 0;     // compared, and see an emitter
  std::size_t backdrop_pixels = 0;    // compared, and see none of it
  std::size_t silhouette_pixels = 0;  // left out
  // Left out, too: those of textures that are looked up and not filtered, where rounding decides.
  std::size_t texel_edge_pixels = 0;
  int allowed_difference = 1;        // display codes: 1, or 2 for a glossy pack
  int largest_difference = 0;        // display codes, over all channels of the compared pixels
  std::size_t differing_pixels = 0;  // by one code or more
  int worst_x = 0, worst_y = 0;

  // Every compared channel within the allowed codes, at most a twentieth of the pixels off (rounding; more
  // would be a bias), and at least a fifth of the picture compared on the object.
  bool agrees() const {
    return largest_difference <= allowed_difference && differing_pixels * 20 <= pixels &&
           (object_pixels + texel_edge_pixels) * 5 >= pixels;
  }
  // One line with all of the above.
  std::string summary() const;
};

// What shines: files and the parameters that go with them.
struct PlayerLights {
  std::filesystem::path environment_path = {}, rig_path = {};  // both empty: the default light
  std::optional<double> windowing = {};
  int cube_resolution = 64;
};

// What stands around the object.
struct PlayerSurroundings {
  std::optional<formats::Float3> ground_albedo = {};  // nothing: no ground
  std::optional<transport::Receiver> receiver = {};   // a unitSphere
};

// Runs the `player` executable on the files and renders the same frame by transport::evaluatePack and
// transport::renderOnCpu, near light by transport::renderEmitterCube and projectCubeMap, surroundings by
// transport::GroundShading and VolumeShading. Left out are
// silhouette pixels (silhouette.h). Writes player.png and cpu.png into `folder`. Throws std::runtime_error if
// the player fails.
PlayerComparison comparePlayerWithCpu(const std::filesystem::path& player_executable,
                                      const std::filesystem::path& pack_path, const PlayerLights& lights,
                                      const formats::FrameSettings& settings,
                                      const std::filesystem::path& folder,
                                      const PlayerSurroundings& surroundings = {});

}  // namespace bakelight::tests
