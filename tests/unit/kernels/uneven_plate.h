// A plate whose medium varies, and how far its kernels are from the sum of R_d over all texels, each by what its way has.
#pragma once

#include "tests/support/plate.h"
#include "transport/translucent_response.h"

namespace bakelight::kernels {

constexpr int kTexels = 100;

// Of even light, or that of a checkerboard of such squares of texels.
inline std::vector<formats::Float3> responseOf(const formats::Translucency& translucency, int square) {
  std::vector<formats::Float3> light;
  for (const std::uint32_t place : formats::wordsOf(translucency.texels)) {
    const std::uint32_t x = place % kTexels, y = place / kTexels;
    const float value = square == 0 || (x / square + y / square) % 2 == 0 ? 1 : 0;
    light.push_back({value, value, value});
  }
  return transport::TranslucentResponse(translucency).respond(light);
}

struct Plate {
  tests::TemporaryFolder folder;
  formats::TriangleMesh mesh = tests::plateMesh(kTexels, 4.4);
  Plate() { tests::writeMaps(mesh, kTexels, folder / "maps.exr"); }
  formats::Translucency made(const formats::Medium& medium, const Options& options = {}) const {
    return makeTranslucency(mesh, folder / "maps.exr", medium, options, stage::ProgressStyle::kNone)
        .translucency;
  }
};

// Relative RMSE over some receivers.
inline double errorOf(const Plate& plate, const formats::Translucency& translucency,
                      const formats::Medium& medium, int square) {
  Knots knots = knotsOf(plate.mesh);
  Texels texels = texelsOf(plate.folder / "maps.exr", plate.mesh, knots);
  const transport::MediumField field(medium, plate.mesh);
  takeSurroundings(field, plate.mesh, knots, texels);
  const Reflectance reflectance(field, 200, 1, 1.01);
  const auto found = responseOf(translucency, square);
  const auto receivers = formats::wordsOf(translucency.receivers);
  double difference = 0, squares = 0;
  for (std::size_t r = 7; r < receivers.size(); r += 61) {
    const std::size_t texel = receivers[r];
    if (texels.areas[texel] == 0) continue;
    Rgb truth = Rgb::Zero();
    for (std::size_t s = 0; s < texels.count(); ++s) {
      const std::uint32_t x = texels.places[s] % kTexels, y = texels.places[s] / kTexels;
      if (square > 0 && (x / square + y / square) % 2 == 1) continue;
      truth += texels.areas[s] *
               reflectance.betweenTexels((texels.positions[s] - texels.positions[texel]).norm(),
                                         texels.sides[texel], reflectance.bandOf(texels.sides[texel]),
                                         reflectance.along(texels.point(s), texels.point(texel)));
    }
    difference += static_cast<double>((Rgb(found[r][0], found[r][1], found[r][2]) - truth).square().sum());
    squares += static_cast<double>(truth.square().sum());
  }
  return std::sqrt(difference / squares);
}

}  // namespace bakelight::kernels
