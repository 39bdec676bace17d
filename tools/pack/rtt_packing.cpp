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

namespace bakelight::packing {
namespace {

using formats::RadianceTransferTexture;
using formats::RttLevel;
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

// Shares of the texels of a row of `from` that each of `to` texels covers.
struct Cover {
  int first = 0;
  std::vector<double> shares;  // sum 1
};
std::vector<Cover> covers(int from, int to) {
  std::vector<Cover> result(static_cast<std::size_t>(to));
  for (int i = 0; i < to; ++i) {
    const double begin = static_cast<double>(i) * from / to, end = static_cast<double>(i + 1) * from / to;
    Cover& cover = result[static_cast<std::size_t>(i)];
    cover.first = static_cast<int>(begin);
    for (int x = cover.first; x < end && x < from; ++x)
      cover.shares.push_back((std::min(end, x + 1.0) - std::max<double>(begin, x)) / (end - begin));
  }
  return result;
}

// Of one view: texels × components.
Matrix meansOver(const Matrix& finest, int width, int height, const RttLevel& level) {
  const std::vector<Cover> across = covers(width, level.width), down = covers(height, level.height);
  Matrix means = Matrix::Zero(static_cast<Eigen::Index>(level.width) * level.height, finest.cols());
  for (int y = 0; y < level.height; ++y)
    for (int x = 0; x < level.width; ++x)
      for (std::size_t j = 0; j < down[y].shares.size(); ++j)
        for (std::size_t i = 0; i < across[x].shares.size(); ++i)
          means.row(static_cast<Eigen::Index>(y) * level.width + x) +=
              static_cast<float>(down[y].shares[j] * across[x].shares[i]) *
              finest.row(static_cast<Eigen::Index>(down[y].first + static_cast<int>(j)) * width +
                         across[x].first + static_cast<int>(i));
  return means;
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
    if (material.patch && !material.patch->btf.empty())
      patches.btfs[name] = formats::openBtf(material.patch->btf);
  };
  take("", materials.base);
  for (const auto& [name, material] : materials.by_name) take(name, material);
}

FactoringFigures factorPatch(const PatchSamples& source, double error, formats::Precision precision,
                             const std::string& file, formats::FactoredPatch& patch) {
  const auto texels = static_cast<Eigen::Index>(source.width) * source.height;
  const auto views = static_cast<Eigen::Index>(source.views) * source.views;
  const Samples samples(source.values.data(), views * texels, static_cast<Eigen::Index>(source.incident));
  const Basis basis = principalComponents(samples, error);
  const Eigen::Index components = basis.columns.cols();
  const std::vector<RttLevel> levels = formats::rttLevels(source.width, source.height);
  const auto rowOf = [&](std::size_t texel, Eigen::Index view) {
    return (texel * static_cast<std::size_t>(views) + static_cast<std::size_t>(view)) *
           static_cast<std::size_t>(components);
  };

  std::vector<float> factors(formats::rttTexelCount(levels) * static_cast<std::size_t>(views * components));
  tbb::parallel_for(Eigen::Index{0}, views, [&](Eigen::Index view) {
    const Matrix finest = samples.middleRows(view * texels, texels) * basis.columns;
    for (const RttLevel& level : levels) {
      const Matrix means =
          level.first_texel == 0 ? finest : meansOver(finest, source.width, source.height, level);
      for (Eigen::Index t = 0; t < means.rows(); ++t)
        std::copy_n(means.row(t).data(), components,
                    &factors[rowOf(level.first_texel + static_cast<std::size_t>(t), view)]);
    }
  });

  patch.views = source.views;
  patch.width = source.width;
  patch.height = source.height;
  patch.components = static_cast<int>(components);
  patch.factors = formats::encodeTable(factors, static_cast<std::size_t>(components), precision, file,
                                       "factors of the patch");
  patch.basis.assign(basis.columns.data(),
                     basis.columns.data() + basis.columns.size());  // column by column
  // The basis is orthonormal, so what factors lose is lost in values, beside what components leave.
  const std::vector<float> stored = patch.factors.decode();
  double lost = 0;
  for (std::size_t i = 0; i < rowOf(static_cast<std::size_t>(texels), 0); ++i)
    lost += (double{stored[i]} - factors[i]) * (double{stored[i]} - factors[i]);
  const double total = basis.total > 0 ? lost / basis.total : 0;
  return {basis.error, std::sqrt(basis.error * basis.error + total)};
}

PackedRtt packRtt(const RadianceTransferTexture& texture, const RttPackingOptions& options,
                  const std::string& file) {
  PackedRtt packed;
  packed.reflection.order = texture.order;
  packed.error =
      factorPatch({texture.values, texture.views, texture.width, texture.height, texture.responseSize()},
                  options.error, options.precision, file, packed.reflection)
          .components;
  packed.reflection.heights = reliefOf(texture, options, file);
  return packed;
}

std::optional<formats::EncodedTable> reliefOf(const RadianceTransferTexture& texture,
                                              const RttPackingOptions& options, const std::string& file) {
  if (!options.relief ||
      std::all_of(texture.heights.begin(), texture.heights.end(), [](float h) { return h == 0; }))
    return std::nullopt;
  const std::vector<RttLevel> levels = formats::rttLevels(texture.width, texture.height);
  const std::size_t views = texture.viewCount();
  std::vector<float> heights(formats::rttTexelCount(levels) * views);
  for (std::size_t view = 0; view < views; ++view) {
    const Matrix finest = Eigen::Map<const Matrix>(&texture.heights[view * texture.texelCount()],
                                                   static_cast<Eigen::Index>(texture.texelCount()), 1);
    for (const RttLevel& level : levels) {
      const Matrix means =
          level.first_texel == 0 ? finest : meansOver(finest, texture.width, texture.height, level);
      for (Eigen::Index t = 0; t < means.rows(); ++t)
        heights[(level.first_texel + static_cast<std::size_t>(t)) * views + view] = means(t, 0);
    }
  }
  return formats::encodeTable(heights, 1, formats::Precision::kFloat16, file, "heights of the patch");
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
