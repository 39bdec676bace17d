#include <cstdio>
#include <chrono>
#include <numbers>
#include <cstdlib>
#include <iostream>
#include "formats/image.h"
#include "formats/rtt_reflection.h"
#include "tests/bench/biscale_images.h"
#include "transport/light_rig.h"

using namespace bakelight;
using namespace bakelight::bench;

formats::LightRig rigOf(double across_deg) {
  formats::LightRig rig;
  if (across_deg == 0) { formats::SkyLight sky; sky.sun = false; rig.distant.emplace_back(sky); return rig; }
  const double p = 45 * std::numbers::pi / 180, a = 75 * std::numbers::pi / 180;
  formats::DiskLight disk;
  disk.direction = transport::float3(Vec3(std::sin(p) * std::cos(a), std::cos(p), -std::sin(p) * std::sin(a)));
  disk.half_angle_deg = across_deg / 2;
  rig.distant.emplace_back(disk);
  return rig;
}
void put(const std::vector<const Image*>& images, const std::string& name) {
  const int side = images[0]->side;
  formats::Image out(side * static_cast<int>(images.size()), side, {"R", "G", "B"});
  double most = 0;
  for (const auto& v : images[0]->values) most = std::max<double>(most, v[1]);
  for (std::size_t k = 0; k < images.size(); ++k)
    for (int y = 0; y < side; ++y) for (int x = 0; x < side; ++x) for (int c = 0; c < 3; ++c)
      out.texel(static_cast<int>(k) * side + x, side - 1 - y)[c] = static_cast<float>(std::pow(std::max(0.0, images[k]->values[static_cast<std::size_t>(y) * side + x][c] / most), 1 / 2.2));
  formats::writePng(name, out);
}
int main(int argc, char** argv) {
  const std::string patch = argv[1];
  const Macro macro = static_cast<Macro>(std::atoi(argv[2]));
  BakeVariant variant;
  if (argc > 3) variant.order = std::atoi(argv[3]);
  if (argc > 4) variant.views = std::atoi(argv[4]);
  if (argc > 5) variant.resolution = std::atoi(argv[5]);
  if (argc > 6) variant.macro_steps = std::atoi(argv[6]);
  const auto t0 = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count(); };
  const reference::Surface surface = truthOf(patch, macro);
  std::printf("%zu triangles %.1f s\n", surface.mesh.triangleCount(), seconds());
  const Packs packs = packsOf(patch, macro, variant);
  std::printf("packs %.1f s, %d components\n", seconds(), packs.bi_scale.appearances[0].reflection.as<formats::RttReflection>()->components);
  const NormalMap map = normalMapOf(patchOf(patch), 64);
  for (const double across : {10.0, 40.0, 110.0, 0.0}) {
    const formats::LightRig rig = rigOf(across);
    const auto light = transport::distantLight(rig, variant.order).light;
    const reference::Scene scene(surface, rig, {}, transport::boundingSphere(surface.mesh));
    for (const double polar : {0.0, 30.0, 60.0, 75.0}) {
      const Window window{128, polar, 30};
      const Image truth = truthImage(scene, macro, window, 4);
      const Image bi = packImage(packs.bi_scale, macro, variant.macro_steps, light, window),
                  flat = packImage(packs.macro_only, macro, variant.macro_steps, light, window),
                  meso = packImage(packs.meso_only, macro, variant.macro_steps, light, window),
                  normals = normalMapImage(map, macro, light, window);
      const auto mean = [](const Image& image) { double s = 0; for (const auto& v : image.values) s += v[1]; return s / static_cast<double>(image.values.size()); };
      const Image blurred = truth.blurred(2);
      const auto e = [&](const Image& i) { return 100 * relativeRmse(i.blurred(2), blurred); };
      std::printf("%5.0f° view %2.0f: bi %5.1f (sharp %5.1f) macro %5.1f meso %5.1f normal %5.1f | means %.4f %.4f %.4f %.4f %.4f  noise %.2f%% %.0f s\n", across, polar, e(bi), 100 * relativeRmse(bi, truth), e(flat), e(meso), e(normals), mean(truth), mean(bi), mean(flat), mean(meso), mean(normals),
        100*std::sqrt(blurred.variance / [&]{double s=0; for (auto& v : blurred.values) for (float c : v) s += double(c)*c; return s;}()), seconds());
      std::fflush(stdout);
      put({&truth, &bi, &normals}, "build/biscale_" + patch + "_" + nameOf(macro) + "_" + std::to_string(int(across)) + "_" + std::to_string(int(polar)) + ".png");
    }
  }
}
