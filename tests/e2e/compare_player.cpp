// compare_player: renders a frame with the player and on the CPU, prints how far they are apart, and leaves
// both pictures in FOLDER. Exit status 0 if they agree, 1 if not, 2 if something failed.
#include <cstdio>
#include <exception>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>

#include "tests/e2e/player_comparison.h"

namespace {

constexpr const char* kUsage =
    "usage: compare_player PLAYER PACK FOLDER [--environment FILE] [--lights FILE] [--windowing X]\n"
    "       [--cube-resolution PX] [--width PX] [--height PX] [--supersampling N] [--yaw-deg X] [--pitch-deg "
    "X]\n"
    "       [--distance X] [--light-yaw-deg X] [--light-pitch-deg X] [--object-yaw-deg X]\n"
    "       [--object-pitch-deg X] [--time-s X] [--exposure-ev X]\n";

struct Arguments {
  bakelight::tests::PlayerLights lights;
  bakelight::formats::FrameSettings settings;
};

Arguments parse(int argc, char** argv, int first) {
  Arguments arguments;
  auto& [lights, settings] = arguments;
  using Assign = std::function<void(const std::string&)>;
  const auto real = [](double& value) -> Assign {
    return [&value](const std::string& word) { value = std::stod(word); };
  };
  const auto integer = [](int& value) -> Assign {
    return [&value](const std::string& word) { value = std::stoi(word); };
  };
  const auto path = [](std::filesystem::path& value) -> Assign {
    return [&value](const std::string& word) { value = word; };
  };
  const std::map<std::string, Assign> options = {
      {"--environment", path(lights.environment_path)},
      {"--lights", path(lights.rig_path)},
      {"--windowing", [&](const std::string& word) { lights.windowing = std::stod(word); }},
      {"--cube-resolution", integer(lights.cube_resolution)},
      {"--width", integer(settings.width_px)},
      {"--height", integer(settings.height_px)},
      {"--supersampling", integer(settings.supersampling)},
      {"--yaw-deg", real(settings.yaw_deg)},
      {"--pitch-deg", real(settings.pitch_deg)},
      {"--distance", real(settings.distance)},
      {"--light-yaw-deg", real(settings.light_yaw_deg)},
      {"--light-pitch-deg", real(settings.light_pitch_deg)},
      {"--object-yaw-deg", real(settings.object_yaw_deg)},
      {"--object-pitch-deg", real(settings.object_pitch_deg)},
      {"--time-s", real(settings.time_s)},
      {"--exposure-ev", real(settings.exposure_ev)}};
  for (int i = first; i < argc; i += 2) {
    const auto option = options.find(argv[i]);
    if (option == options.end() || i + 1 == argc) throw std::invalid_argument(kUsage);
    option->second(argv[i + 1]);
  }
  return arguments;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  try {
    const Arguments arguments = parse(argc, argv, 4);
    const auto result = bakelight::tests::comparePlayerWithCpu(argv[1], argv[2], arguments.lights,
                                                               arguments.settings, argv[3]);
    std::printf("%s\n", result.summary().c_str());
    return result.agrees() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
