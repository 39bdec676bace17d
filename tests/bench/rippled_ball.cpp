// rippled_ball TRIANGLES FILE.ply: the ball of tests/support/rippled_ball.h as a mesh to run tools on.
#include "tests/support/rippled_ball.h"

#include <charconv>
#include <iostream>
#include <string_view>

#include "formats/error.h"
#include "formats/mesh_ply.h"

int main(int argc, char** argv) {
  using namespace bakelight;
  std::size_t triangles = 0;
  const std::string_view number = argc == 3 ? argv[1] : "";
  const auto read = std::from_chars(number.data(), number.data() + number.size(), triangles);
  if (number.empty() || read.ptr != number.data() + number.size() || triangles < 20 ||
      triangles > 100'000'000) {
    std::cerr << "usage: rippled_ball TRIANGLES FILE.ply, of 20 to 100000000 triangles\n";
    return static_cast<int>(ExitStatus::kUsage);
  }
  try {
    formats::writePly(argv[2], tests::rippledBall(triangles));
  } catch (const Error& error) {
    std::cerr << "rippled_ball: " << error.paragraph() << '\n';
    return static_cast<int>(error.status());
  }
}
