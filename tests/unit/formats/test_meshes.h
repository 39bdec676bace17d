// Small meshes and scratch files for the tests of formats.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// A fresh folder, removed at the end of the test.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "bakelight-test-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~ScratchFolder() { std::filesystem::remove_all(path_); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::size_t fileCount() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

// Without the sync of writeFileAtomically, which costs milliseconds: for the hundreds of files of a
// truncation test.
inline void writeQuickly(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// A height field over the unit square, n × n vertices (n >= 2), every position different.
inline TriangleMesh wavyGrid(std::uint32_t n) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(n - 1);
      const float v = static_cast<float>(j) / static_cast<float>(n - 1);
      mesh.positions.push_back({u, 0.1F * std::sin(7 * u + 3 * v), -v});
      const Float3 normal = {-0.7F * std::cos(7 * u + 3 * v), 1, 0.3F * std::cos(7 * u + 3 * v)};
      const float length = std::hypot(normal[0], normal[1], normal[2]);
      mesh.normals.push_back({normal[0] / length, normal[1] / length, normal[2] / length});
      mesh.texcoords.push_back({u, v});
    }
  }
  for (std::uint32_t j = 0; j + 1 < n; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i;
      mesh.triangles.push_back({a, a + 1, a + n + 1});
      mesh.triangles.push_back({a, a + n + 1, a + n});
    }
  }
  return mesh;
}

}  // namespace bakelight::formats
