// compare_player PLAYER PACK ENVIRONMENT|- FOLDER: renders the default frame with the player and on the CPU,
// prints how far they are apart, and leaves both pictures in FOLDER. Exit status 0 if they agree, 1 if not, 2
// if something failed.
#include <cstdio>
#include <exception>
#include <string>

#include "tests/e2e/player_comparison.h"

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: %s PLAYER PACK ENVIRONMENT|- FOLDER\n", argv[0]);
    return 2;
  }
  const std::string environment = argv[3];
  try {
    const auto result = bakelight::tests::comparePlayerWithCpu(
        argv[1], argv[2], environment == "-" ? "" : environment, bakelight::player::FrameSettings{}, argv[4]);
    std::printf("%s\n", result.summary().c_str());
    return result.agrees() ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
