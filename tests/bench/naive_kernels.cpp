// naive_kernels ATLAS.ply MAPS.exr MATERIAL.json KERNELS.safetensors: what the tool `kernels` writes, but before the branches are blended (Lensch et al. 2002,
// before section 5.4): kernels are R_d itself, factors are R_d between vertices with a diagonal of 0, and both are added up. For the figure that compares.
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/material.h"
#include "formats/mesh_ply.h"
#include "formats/part_tensors.h"
#include "tools/kernels/kernels.h"

namespace bakelight::bench {
namespace {

using kernels::Rgb;
constexpr int kReach = formats::kKernelSide / 2;

// Of each receiver R_d to the texels of its own chart around it.
formats::EncodedTable plainKernels(const kernels::Texels& texels, const kernels::Reflectance& reflectance,
                                   std::span<const std::uint32_t> receivers) {
  const std::size_t columns = std::size_t{3} * formats::kKernelTexels;
  std::vector<float> values(receivers.size() * columns, 0);
  for (std::size_t r = 0; r < receivers.size(); ++r) {
    const std::size_t receiver = receivers[r];
    const std::uint32_t band = reflectance.bandOf(texels.sides[receiver]);
    float* to = &values[r * columns];
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx, to += 3) {
        const std::int32_t s = texels.neighbour(receiver, dx, dy);
        if (s < 0) continue;
        const auto source = static_cast<std::size_t>(s);
        const float distance = (texels.positions[source] - texels.positions[receiver]).norm();
        const Rgb value =
            texels.cells[source] *
            reflectance.betweenTexels(distance, texels.sides[receiver], band,
                                      reflectance.along(texels.point(source), texels.point(receiver)));
        for (int c = 0; c < 3; ++c) to[c] = value[c];
      }
  }
  return formats::encodeTable(values, columns, formats::Precision::kFloat16, "naive", "kernels");
}

// Where factors are smooth, R_d in its place, and nothing on the diagonal.
formats::EncodedTable plainFactors(const kernels::Knots& knots, const kernels::Reflectance& reflectance,
                                   const kernels::Throughput& throughput, float area_unit) {
  std::vector<float> values = throughput.near().values;
  std::vector<std::uint32_t> along;
  for (std::size_t k = 0; k < knots.count(); ++k) {
    const auto columns = kernels::Knots::row(throughput.near().columns, throughput.near().ends, k);
    const auto first = static_cast<std::size_t>(columns.data() - throughput.near().columns.data());
    kernels::alongSurface(knots, k, static_cast<double>(throughput.outerSmoothing()), along);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::size_t other = columns[i];
      const auto distance = static_cast<float>((knots.positions[k] - knots.positions[other]).norm());
      const float radius = (throughput.smoothing(k) + throughput.smoothing(other)) / 2;
      if (distance >= radius || !std::binary_search(along.begin(), along.end(), columns[i])) continue;
      const Rgb plain =
          other == k ? Rgb(Rgb::Zero())
                     : reflectance.exact(distance, reflectance.along(knots.point(k), knots.point(other)));
      const Rgb more = plain - throughput.between(k, other);
      for (std::size_t c = 0; c < 3; ++c) values[3 * (first + i) + c] += more[static_cast<Eigen::Index>(c)];
    }
  }
  for (float& value : values) value *= area_unit;
  return formats::encodeTable(values, 3, formats::Precision::kFloat16, "naive", "near");
}

void writeNaive(char** files) {
  formats::TriangleMesh mesh = formats::readPly(files[0]);
  const formats::SurfaceMaterials surface =
      formats::materialsOn(mesh, formats::readMaterials(files[2]), files[0], files[2]);
  mesh.colors = surface.medium_reflectance;
  const std::optional<formats::Medium>& medium = surface.media.front();
  if (!medium) throw badInput({files[2], "", "/medium"}, "there is none", "one");
  formats::Translucency result =
      kernels::makeTranslucency(mesh, files[1], *medium, {}, stage::ProgressStyle::kNone).translucency;

  kernels::Knots knots = kernels::knotsOf(mesh);
  kernels::Texels texels = kernels::texelsOf(files[1], mesh, knots);
  const transport::MediumField field(*medium, mesh);
  kernels::takeSurroundings(field, mesh, knots, texels);
  const auto [least, greatest] = std::minmax_element(texels.sides.begin(), texels.sides.end());
  kernels::Vec3 low = knots.positions.front(), high = low;
  for (const kernels::Vec3& p : knots.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const kernels::Reflectance reflectance(field, (high - low).norm() * 1.001, static_cast<double>(*least),
                                         static_cast<double>(*greatest));
  const kernels::Throughput throughput(knots, reflectance, {});
  result.components = 0;
  result.basis.clear();
  result.kernels = plainKernels(texels, reflectance, formats::wordsOf(result.receivers));
  result.near.values = plainFactors(knots, reflectance, throughput, result.area_unit);
  result.blend = formats::encodeTable(std::vector<float>(9 * texels.count(), 0), 9,
                                      formats::Precision::kFloat16, "naive", "blend");
  formats::PackPart part(std::move(result));
  formats::writeSafetensors(files[3], formats::tensorsOf(part));
}

}  // namespace
}  // namespace bakelight::bench

int main(int argc, char** argv) {
  using namespace bakelight;
  if (argc != 5) {
    std::cerr << "usage: naive_kernels ATLAS.ply MAPS.exr MATERIAL.json KERNELS.safetensors\n";
    return static_cast<int>(ExitStatus::kUsage);
  }
  try {
    bench::writeNaive(argv + 1);
  } catch (const Error& error) {
    std::cerr << "naive_kernels: " << error.paragraph() << '\n';
    return static_cast<int>(error.status());
  }
}
