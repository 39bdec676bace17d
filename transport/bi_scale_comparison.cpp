#include "transport/bi_scale_comparison.h"

#include <algorithm>
#include <Eigen/Geometry>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "formats/rtt_reflection.h"
#include "transport/bi_scale_shading.h"
#include "transport/sh.h"
#include "transport/vector_types.h"

namespace bakelight::transport {
namespace {

using formats::RttReflection;

// One view of each texel, made of those of the grid by `combine(first factor of the texel, component)`.
template <class Combine>
RttReflection oneView(const RttReflection& source, const Combine& combine) {
  RttReflection result = source;
  const std::size_t views = static_cast<std::size_t>(source.views) * source.views,
                    components = static_cast<std::size_t>(source.components);
  const std::vector<float> factors = source.factors.decode();
  std::vector<float> combined(factors.size() / views);
  for (std::size_t texel = 0; texel < combined.size() / components; ++texel)
    for (std::size_t k = 0; k < components; ++k)
      combined[texel * components + k] = combine(&factors[texel * views * components], k);
  result.views = 1;
  result.heights.reset();
  result.factors =
      formats::encodeTable(combined, components, source.factors.precision, "pack", "factors of one view");
  return result;
}

// Of the cells around the zenith: one, or four.
RttReflection fromZenith(const RttReflection& source) {
  const int first = (source.views - 1) / 2, last = source.views / 2;
  return oneView(source, [&](const float* texel, std::size_t k) {
    float sum = 0;
    for (const int row : {first, last})
      for (const int column : {first, last})
        sum += texel[static_cast<std::size_t>((row * source.views + column) * source.components) + k];
    return sum / 4;
  });
}

RttReflection meanOverViews(const RttReflection& source) {
  const int views = source.views * source.views;
  return oneView(source, [&](const float* texel, std::size_t k) {
    double sum = 0;
    for (int view = 0; view < views; ++view)
      sum += texel[static_cast<std::size_t>(view * source.components) + k];
    return static_cast<float>(sum / views);
  });
}

// What a uniform sky loses, of the mean over places and views.
Float3 meanAlbedo(const RttReflection& reflection) {
  const RttReflection mean = meanOverViews(reflection);
  const std::vector<float> factors = mean.factors.decode();
  const std::size_t components = static_cast<std::size_t>(mean.components),
                    last = factors.size() - components;
  Float3 albedo = {0, 0, 0};
  for (std::size_t k = 0; k < components; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      albedo[c] += factors[last + k] * mean.basisOf(static_cast<int>(k))[c * coefficientCount(mean.order)] *
                   static_cast<float>(2 * std::sqrt(std::numbers::pi));
  for (float& value : albedo) value = std::clamp(value, 0.0F, 1.0F);
  return albedo;
}

void turnOnly(formats::Pack& pack) {
  formats::ShTransfer& transfer = pack.sh();
  formats::GlossyTransfer& glossy = transfer.glossy.value();
  const std::size_t rows = coefficientCount(glossy.output_order), columns = coefficientCount(transfer.order);
  const std::size_t channels = static_cast<std::size_t>(transfer.channels);
  std::vector<float> matrices(pack.mesh.vertexCount() * channels * rows * columns, 0.0F);
  const int bands = std::min(glossy.output_order, transfer.order);
  for (std::size_t v = 0; v < pack.mesh.vertexCount(); ++v) {
    const formats::Float4& tangent = glossy.tangents[v];
    const Vec3 n = vec3(pack.mesh.normals[v]).normalized(), along(tangent[0], tangent[1], tangent[2]);
    Eigen::Matrix3d local;
    local.row(0) = (along - along.dot(n) * n).normalized();
    local.row(1) = tangent[3] * n.cross(Vec3(local.row(0)));
    local.row(2) = n;
    const ShRotation rotation(bands, local);
    for (std::size_t channel = 0; channel < channels; ++channel)
      for (int l = 0; l < bands; ++l)
        for (int i = 0; i <= 2 * l; ++i)
          for (int j = 0; j <= 2 * l; ++j)
            matrices[((v * channels + channel) * rows + static_cast<std::size_t>(l * l + i)) * columns +
                     static_cast<std::size_t>(l * l + j)] = static_cast<float>(rotation.band(l)(i, j));
  }
  glossy.transfer = formats::MatrixOperator{formats::encodeTable(
      matrices, channels * rows * columns, formats::Precision::kFloat32, "pack", "turns")};
}

}  // namespace

formats::Pack withEffects(formats::Pack pack, BiScaleEffects effects) {
  if (effects == BiScaleEffects::kAll) return pack;
  if (!BiScaleShading::shades(pack)) throw std::invalid_argument("the pack has no radiance transfer texture");
  if (effects == BiScaleEffects::kNoMacro) {
    turnOnly(pack);
    return pack;
  }
  for (formats::Appearance& appearance : pack.appearances) {
    auto* rtt = appearance.reflection.as<RttReflection>();
    if (rtt == nullptr) continue;
    if (effects == BiScaleEffects::kNoMasking) *rtt = fromZenith(*rtt);
    if (effects == BiScaleEffects::kDiffuse) *rtt = meanOverViews(*rtt);
    if (effects != BiScaleEffects::kNoMeso) continue;
    appearance.base_color = meanAlbedo(*rtt);
    appearance.reflection = formats::LambertReflection();
  }
  if (effects == BiScaleEffects::kNoMeso) pack.sh().glossy.reset();
  return pack;
}

}  // namespace bakelight::transport
