// A tube as a mesh file, with texture coordinates of every quality.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

namespace bakelight::tests {

inline constexpr int kAround = 24, kAlong = 8;  // of the tube, squares

enum class Uv { kNone, kUnrolled, kOverlapping };

// A tube around z as an OBJ; the seam has two texture coordinates a vertex.
inline void writeTube(const std::filesystem::path& path, Uv uv) {
  std::ofstream file(path);
  for (int j = 0; j <= kAlong; ++j)
    for (int i = 0; i < kAround; ++i) {
      const double angle = 2 * std::numbers::pi * i / kAround;
      file << "v " << std::cos(angle) << ' ' << std::sin(angle) << ' ' << 0.5 * j << '\n';
    }
  const double wide = uv == Uv::kOverlapping ? 1.9 : 0.95;
  for (int j = 0; j <= kAlong && uv != Uv::kNone; ++j)
    for (int i = 0; i <= kAround; ++i)
      file << "vt " << std::fmod(0.02 + wide * i / kAround, 0.98) << ' ' << 0.02 + 0.9 * j / kAlong << '\n';
  const auto corner = [&](int i, int j) {
    file << ' ' << j * kAround + i % kAround + 1;
    if (uv != Uv::kNone) file << '/' << j * (kAround + 1) + i + 1;
  };
  for (int j = 0; j < kAlong; ++j)
    for (int i = 0; i < kAround; ++i)
      for (const auto& t : {std::array{0, 0, 1, 0, 1, 1}, std::array{0, 0, 1, 1, 0, 1}}) {
        file << 'f';
        for (std::size_t k = 0; k < 3; ++k) corner(i + t[2 * k], j + t[2 * k + 1]);
        file << '\n';
      }
}

}  // namespace bakelight::tests
