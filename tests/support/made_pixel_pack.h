// A pack in a pixel basis with a made-up BTF.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "formats/btf_reflection.h"
#include "formats/pack_contents.h"
#include "formats/pixel_transfer.h"
#include "tests/support/made_rtt.h"

namespace bakelight::tests {

inline formats::BtfReflection madeBtf(int lights, int views, int width, int height, int components) {
  formats::BtfReflection btf;
  static_cast<formats::FactoredPatch&>(btf) = madeRtt(lights, views, width, height, components);
  btf.lights = lights;
  btf.error = 0.03F;
  return btf;
}

// 4 × 4 cells, 2 × 2 subsamples; rows of lengths that differ.
inline formats::PixelTransfer madePixelTransfer(const formats::TriangleMesh& mesh, int cube_side = 3) {
  formats::PixelRows rows;
  rows.cube_side = cube_side;
  rows.local_side = 4;
  const std::size_t texels = rows.view().columnCount();
  std::vector<formats::Float4> tangents;
  for (std::size_t v = 0; v < mesh.vertexCount(); ++v) {
    const transport::Vec3 normal = transport::vec3(mesh.normals[v]);
    const transport::Vec3 tangent = normal.unitOrthogonal();
    const formats::Float3 t = transport::float3(tangent);
    tangents.push_back({t[0], t[1], t[2], v % 3 == 0 ? -1.0F : 1.0F});
    for (std::size_t cell = 0; cell < 16; ++cell) {
      for (std::size_t k = (v + cell) % 5; k < texels; k += 7 + cell) {
        rows.columns.push_back(static_cast<std::uint16_t>(k));
        rows.codes.push_back(static_cast<std::uint8_t>(1 + (k + v) % 4));
      }
      rows.row_offsets.push_back(rows.columns.size());
    }
  }
  return formats::pixelTransferOf(rows.view(), std::move(tangents));
}

inline formats::Pack madePixelPack(formats::TriangleMesh mesh) {
  formats::Pack pack{.name = "pixels", .mesh = std::move(mesh)};
  if (pack.mesh.texcoords.empty()) addSphericalTexcoords(pack.mesh);
  pack.transfer = madePixelTransfer(pack.mesh);
  formats::BtfReflection btf = madeBtf(4, 2, 4, 3, 5);
  btf.index = madeIndex(8, 4);
  pack.appearances.front().reflection = btf;
  return pack;
}

}  // namespace bakelight::tests
