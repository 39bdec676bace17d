// What an engine does with a pack: reads it, and lights its vertices. The light here is the same from all
// directions, so that a body without shadows and dents shines with its albedo everywhere.
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <vector>

#include "formats/pack.h"

using namespace bakelight::formats;

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: read_pack PACK.glb\n");
    return 2;
  }
  try {
    const Pack pack = readPack(argv[1]);
    const ShTransfer& transfer = pack.sh();
    const auto count = static_cast<std::size_t>(transfer.order) * static_cast<std::size_t>(transfer.order);
    const auto channels = static_cast<std::size_t>(transfer.channels);

    // A sky of radiance 1, as coefficients of spherical harmonics.
    std::vector<float> light(count, 0.0F);
    light[0] = static_cast<float>(std::sqrt(4 * std::numbers::pi));

    const std::vector<float> vectors = transfer.vectors.decode();
    double darkest = INFINITY, brightest = 0;
    for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
      double received = 0;  // in the first channel
      for (std::size_t i = 0; i < count; ++i) received += vectors[v * channels * count + i] * light[i];
      darkest = std::fmin(darkest, received);
      brightest = std::fmax(brightest, received);
    }
    std::printf("%s: %zu vertices, %zu triangles, order %d, %s\n", pack.name.c_str(), pack.mesh.vertexCount(),
                pack.mesh.triangleCount(), transfer.order, nameOf(transfer.transport));
    for (const Appearance& appearance : pack.appearances)
      std::printf("material '%s': reflects as %s\n", appearance.material.c_str(),
                  appearance.reflection.kind());
    std::printf("of a sky of radiance 1, vertices receive %.3f to %.3f\n", darkest, brightest);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
