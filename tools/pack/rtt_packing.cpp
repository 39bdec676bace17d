#include "tools/pack/rtt_packing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <nlohmann/json.hpp>
#include <vector>

#include "formats/image.h"
#include "formats/json.h"
#include "formats/json_reader.h"
#include "formats/patch_levels.h"

namespace bakelight::packing {
namespace {

using formats::RadianceTransferTexture;
using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Samples = Eigen::Map<const Matrix>;  // views · texels × 3 · order²

// Σ over all samples of the products of their values; in blocks, added in their order.
Eigen::MatrixXd gramMatrix(const Samples& samples) {
  constexpr Eigen::Index kBlock = 4096;
  const Eigen::Index blocks = (samples.rows() + kBlock - 1) / kBlock;
  std::vector<Eigen::MatrixXd> parts(static_cast<std::size_t>(blocks));
  tbb::parallel_for(Eigen::Index{0}, blocks, [&](Eigen::Index block) {
    const Eigen::Index first = block * kBlock, count = std::min(kBlock, samples.rows() - first);
    const Eigen::MatrixXd values = samples.middleRows(first, count).cast<double>();
    parts[static_cast<std::size_t>(block)] = values.transpose() * values;
  });
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(samples.cols(), samples.cols());
  for (const Eigen::MatrixXd& part : parts) sum += part;
  return sum;
}

struct Basis {
  Eigen::MatrixXf columns;  // values × components
  double error = 0;
  double total = 0;  // Σ value²
};

Basis principalComponents(const Samples& samples, double error) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gramMatrix(samples));
  const Eigen::VectorXd energies = solver.eigenvalues().cwiseMax(0).reverse();
  const double total = energies.sum();
  // Factors are stored by fours, as textures have them: the rest of four costs nothing.
  Eigen::Index count = 0;
  const auto left = [&] {
    return total > 0 ? std::sqrt(std::max(energies.tail(energies.size() - count).sum(), 0.0) / total) : 0;
  };
  do count = std::min<Eigen::Index>(count + 4, energies.size());
  while (count < energies.size() && (error <= 0 || left() > error));
  Basis basis{solver.eigenvectors().rowwise().reverse().leftCols(count).cast<float>(), left(), total};
  // Eigenvectors have no sign of their own; one that no rounding turns: the largest value is positive.
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::Index largest = 0;
    basis.columns.col(k).cwiseAbs().maxCoeff(&largest);
    if (basis.columns(largest, k) < 0) basis.columns.col(k) *= -1;
  }
  return basis;
}

}  // namespace

PatchSources readPatchSources(const std::filesystem::path& rtt, const std::filesystem::path& id_map) {
  PatchSources sources;
  if (!rtt.empty()) sources.textures = formats::readRadianceTransferTextures(rtt);
  if (id_map.empty()) return sources;
  sources.id_map = formats::readIndexExr(id_map, {"patch.U", "patch.V"});
  const std::map<std::string, std::string> metadata = formats::readImageMetadata(id_map);
  const auto widths = metadata.find("bakelight:patch_widths");
  if (widths == metadata.end()) return sources;
  const formats::Json json = formats::parseJson(widths->second, id_map.string());
  const formats::JsonReader reader(json, id_map.string(), "/bakelight:patch_widths");
  for (const std::string& name : reader.keys()) sources.widths[name] = reader.number(name, {1e-30, 1e30});
  return sources;
}

void takeMaterials(const formats::Materials& materials, PatchSources& patches) {
  for (const auto& [name, material] : materials.by_name) patches.own_materials.insert(name);
  if (patches.id_map) return;
  const auto take = [&](const std::string& name, const formats::Material& material) {
    if (material.patch && material.patch->width) patches.widths[name] = *material.patch->width;
  };
  take("", materials.base);
  for (const auto& [name, material] : materials.by_name) take(name, material);
}

void takeBtfs(const formats::Materials& materials, PatchSources& patches) {
  const auto take = [&](const std::string& name, const formats::Material& material) {
    if (material.patch && !material.patch->btf.empty() && !patches.tables.contains(name))
      patches.btfs[name] = formats::openBtf(material.patch->btf);
  };
  take("", materials.base);
  for (const auto& [name, material] : materials.by_name) take(name, material);
}

Factored factored(const PatchSamples& source, double error) {
  const auto texels = static_cast<Eigen::Index>(source.width) * source.height;
  const auto views = static_cast<Eigen::Index>(source.views) * source.views;
  const Samples samples(source.values.data(), views * texels, static_cast<Eigen::Index>(source.incident));
  const Basis basis = principalComponents(samples, error);
  const Eigen::Index components = basis.columns.cols();
  Factored result{static_cast<int>(components),
                  std::vector<float>(static_cast<std::size_t>(views * texels * components)),
                  {basis.columns.data(), basis.columns.data() + basis.columns.size()},  // column by column
                  basis.error,
                  basis.total};
  tbb::parallel_for(Eigen::Index{0}, views, [&](Eigen::Index view) {
    const Matrix finest = samples.middleRows(view * texels, texels) * basis.columns;
    for (Eigen::Index t = 0; t < texels; ++t)
      std::copy_n(finest.row(t).data(), components,
                  &result.values[static_cast<std::size_t>((t * views + view) * components)]);
  });
  return result;
}

PackedRtt packRtt(const RadianceTransferTexture& texture, const RttPackingOptions& options,
                  const std::string& file) {
  PackedRtt packed;
  Factored made = factored(
      {texture.values, texture.views, texture.width, texture.height, texture.responseSize()}, options.error);
  packed.error = made.error;
  formats::RttReflection& rtt = packed.reflection;
  rtt.order = texture.order;
  rtt.views = texture.views;
  rtt.width = texture.width;
  rtt.height = texture.height;
  rtt.components = made.components;
  const auto components = static_cast<std::size_t>(made.components);
  rtt.factors = formats::encodeTable(
      formats::withLevels(made.values, texture.width, texture.height, texture.viewCount() * components),
      components, options.precision, file, "factors of the patch");
  rtt.basis = std::move(made.basis);
  rtt.heights = reliefOf(texture, options, file);
  return packed;
}

std::vector<float> heightsByTexel(const RadianceTransferTexture& texture, const RttPackingOptions& options) {
  if (!options.relief ||
      std::all_of(texture.heights.begin(), texture.heights.end(), [](float h) { return h == 0; }))
    return {};
  const std::size_t views = texture.viewCount(), texels = texture.texelCount();
  std::vector<float> heights(texture.heights.size());
  for (std::size_t view = 0; view < views; ++view)
    for (std::size_t t = 0; t < texels; ++t) heights[t * views + view] = texture.heights[view * texels + t];
  return heights;
}

std::optional<formats::EncodedTable> reliefOf(const RadianceTransferTexture& texture,
                                              const RttPackingOptions& options, const std::string& file) {
  const std::vector<float> heights = heightsByTexel(texture, options);
  if (heights.empty()) return std::nullopt;
  return formats::encodeTable(
      formats::withLevels(heights, texture.width, texture.height, texture.viewCount()), 1,
      formats::Precision::kFloat16, file, "heights of the patch");
}

formats::PackImage packIndex(const formats::IndexImage& id_map) {
  const int u = id_map.channelIndex("patch.U"), v = id_map.channelIndex("patch.V");
  formats::Bytes codes(static_cast<std::size_t>(id_map.width) * id_map.height * 2);
  for (std::size_t i = 0; i < codes.size() / 2; ++i) {
    const std::uint32_t* texel = &id_map.values[i * id_map.channelCount()];
    codes[2 * i] = static_cast<std::byte>(texel[u] >> 8);
    codes[2 * i + 1] = static_cast<std::byte>(texel[v] >> 8);
  }
  formats::PackImage image{id_map.width, id_map.height, {"U", "V"}, {}};
  image.texels.precision = formats::Precision::kUint8;
  image.texels.rows = codes.size() / 2;
  image.texels.columns = 2;
  image.texels.data = std::move(codes);
  image.texels.scale = {1.0F / 256, 1.0F / 256};  // to the middle of each step
  image.texels.offset = {1.0F / 512, 1.0F / 512};
  return image;
}

}  // namespace bakelight::packing
