// The L bracket with materials, colours and texture coordinates, as COLLADA, FBX and 3DS files have them.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "formats/mesh_import.h"
#include "tests/unit/formats/bracket.h"

namespace bakelight::formats {

constexpr std::size_t kFirstBlue = 8;  // triangles before it, both L-shaped sides, are red

inline const std::array<std::string, 2> kPaintNames = {"red", "blue"};
inline const std::array<Float3, 2> kPaints = {Float3{1, 0.25F, 0}, Float3{0, 0.5F, 1}};

inline std::size_t paintOf(std::size_t triangle) {
  return triangle < kFirstBlue ? 0 : 1;
}

// Of the vertex at this position, within 0–1.
inline Float2 texcoordAt(const Float3& p) {
  return {p[0] / 4, (p[1] + p[2]) / 4};
}
inline Float3 vertexColorAt(const Float3& p) {
  return {p[0] / 4, p[1] / 2, 1 - p[2] / 2};
}

// Area, volume and box of the bracket when lengths are multiplied by `scale` and points moved by `moved`, and
// its triangles in order, corner by corner; `turned` if a mirror turned them over.
inline void expectMovedBracket(const TriangleMesh& mesh, const std::function<Float3(const Float3&)>& moved,
                               double scale, const std::string& what, bool turned = false) {
  const TriangleMesh original = bracket();
  ASSERT_EQ(mesh.triangles.size(), original.triangles.size()) << what;
  const BodyFigures figures = figuresOf(mesh);
  EXPECT_NEAR(figures.area / (18 * scale * scale), 1, 1e-5) << what;
  EXPECT_NEAR(figures.volume / (4 * scale * scale * scale), 1, 1e-4) << what;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Float3& read = mesh.positions[mesh.triangles[t][turned ? (3 - k) % 3 : k]];
      const Float3 expected = moved(original.positions[original.triangles[t][k]]);
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(read[c], expected[c], 2e-6 * (1 + std::abs(expected[c])))
            << what << ", triangle " << t << ", corner " << k << ", coordinate " << c;
    }
}

inline void expectPaints(const MeshImport& read, const std::string& what) {
  const TriangleMesh& mesh = read.mesh;
  ASSERT_EQ(mesh.triangle_materials.size(), mesh.triangles.size()) << what;
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size()) << what;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t paint = paintOf(t);
    ASSERT_EQ(mesh.material_names.at(mesh.triangle_materials[t]), kPaintNames[paint])
        << what << ", triangle " << t;
    for (const std::uint32_t v : mesh.triangles[t])
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(mesh.colors[v][c], kPaints[paint][c], 1e-6) << what << ", triangle " << t;
  }
}

inline void expectTexcoords(const std::vector<Float2>& texcoords, const TriangleMesh& mesh,
                            const std::string& what) {
  const TriangleMesh original = bracket();
  ASSERT_EQ(texcoords.size(), mesh.positions.size()) << what;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_EQ(texcoords[mesh.triangles[t][k]], texcoordAt(original.positions[original.triangles[t][k]]))
          << what << ", triangle " << t << ", corner " << k;
}

}  // namespace bakelight::formats
