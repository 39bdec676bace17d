// A translucent plate as a pack, lit by transfer that nothing shadows.
#pragma once

#include <numbers>

#include "formats/pack_contents.h"
#include "tests/support/plate.h"
#include "transport/diffusion.h"
#include "transport/sh.h"

namespace bakelight::tests {

// `waves` changes transfer from vertex to vertex by so much, so that light is uneven.
inline formats::Pack translucentPack(int texels, const formats::Medium& medium, int order, float waves) {
  formats::Pack pack;
  pack.name = "plate";
  pack.mesh = plateMesh(texels, 4.4);
  formats::Translucency translucency = kernelsOf(pack.mesh, texels, medium).translucency;
  const std::vector<double> factors = transport::enteringCosineFactors(order, medium.eta);
  std::vector<float> vectors;
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    const std::vector<double> basis = transport::evaluateSh(order, transport::vec3(pack.mesh.normals[v]));
    const float share = 1 + waves * std::sin(static_cast<float>(v));
    for (int l = 0; l < order; ++l)
      for (int i = l * l; i < (l + 1) * (l + 1); ++i)
        vectors.push_back(share * static_cast<float>(factors[static_cast<std::size_t>(l)] / std::numbers::pi *
                                                     basis[static_cast<std::size_t>(i)]));
  }
  formats::ShTransfer transfer;
  transfer.order = order;
  transfer.transport = formats::Transport::kUnshadowed;
  transfer.vectors = formats::encodeTable(vectors, static_cast<std::size_t>(order) * order,
                                          formats::Precision::kFloat32, "plate", "vectors");
  pack.transfer = std::move(transfer);
  pack.appearances.front().reflection = std::move(translucency);
  return pack;
}

}  // namespace bakelight::tests
