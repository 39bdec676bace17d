#include "transport/bi_scale_shading.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "transport/sh.h"

namespace bakelight::transport {
namespace {

using formats::PackImage;
using formats::RttReflection;

bool isLambert(const formats::Appearance& appearance) {
  return appearance.reflection.as<formats::LambertReflection>() != nullptr;
}

}  // namespace

formats::RttReflection flatReflection(int order) {
  RttReflection flat;
  flat.order = order;
  flat.views = flat.width = flat.height = flat.components = 1;
  flat.patch_width = 1;
  flat.factors = formats::encodeTable(std::array{1.0F}, 1, formats::Precision::kFloat32, "", "flat");
  flat.basis.assign(3 * static_cast<std::size_t>(coefficientCount(order)), 0.0F);
  const std::vector<double> cosine = clampedCosineFactors(order);
  for (int l = 0; l < order; ++l)
    for (std::size_t c = 0; c < 3; ++c)
      flat.basis[c * coefficientCount(order) + static_cast<std::size_t>(l * (l + 1))] =
          static_cast<float>(cosine[l] / std::numbers::pi * std::sqrt((2 * l + 1) / (4 * std::numbers::pi)));
  return flat;
}

struct BiScaleShading::Patch {
  formats::RttReflection reflection;  // without factors and index
  PatchLookup lookup;

  Patch(const RttReflection& source, const PackImage* image) : reflection(source), lookup(source, image) {
    if (source.basis.size() != 3 * static_cast<std::size_t>(source.components) * source.order * source.order)
      throw std::invalid_argument("the basis of a radiance transfer texture does not fit its size");
    reflection.factors = {};
    reflection.heights.reset();
    reflection.index.reset();
  }
};

bool BiScaleShading::shades(const formats::Pack& pack) {
  const auto* transfer = pack.transfer.as<formats::ShTransfer>();
  const auto is_rtt = [](const formats::Appearance& a) {
    return a.reflection.as<RttReflection>() != nullptr;
  };
  return transfer != nullptr && transfer->glossy &&
         std::any_of(pack.appearances.begin(), pack.appearances.end(), is_rtt) &&
         std::all_of(pack.appearances.begin(), pack.appearances.end(),
                     [&](const formats::Appearance& a) { return is_rtt(a) || isLambert(a); });
}

BiScaleShading::BiScaleShading(const formats::Pack& pack)
    : order_(pack.sh().order),
      mesh_(pack.mesh),
      tangents_(pack.sh().glossy.value().tangents),
      transfer_(std::make_unique<GlossyEvaluator>(pack.sh())),
      rows_(static_cast<std::size_t>(coefficientCount(pack.sh().glossy->output_order))),
      ranges_(formats::appearanceRanges(pack)),
      vertex_albedo_(pack.mesh.vertexCount(), Float3{1, 1, 1}) {
  const int output_order = pack.sh().glossy->output_order;
  if (tangents_.size() != mesh_.vertexCount() || mesh_.normals.size() != mesh_.vertexCount())
    throw std::invalid_argument("bi-scale shading needs a normal and a tangent for each vertex");
  const std::vector<const PackImage*> indices = formats::patchIndices(pack);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const formats::Appearance& appearance = pack.appearances[i];
    const auto* rtt = appearance.reflection.as<RttReflection>();
    patches_.push_back(std::make_shared<Patch>(rtt == nullptr ? flatReflection(output_order) : *rtt,
                                               rtt == nullptr ? nullptr : indices[i]));
    components_ = std::max(components_, static_cast<std::size_t>(patches_.back()->reflection.components));
    if (patches_.back()->reflection.order > output_order)
      throw std::invalid_argument("a radiance transfer texture has more bands than the transferred radiance");
    if (rtt != nullptr) {
      if (mesh_.texcoords.size() != mesh_.vertexCount())
        throw std::invalid_argument("radiance transfer textures need texture coordinates");
      continue;
    }
    for (std::size_t v = ranges_[i].first; v < ranges_[i].end; ++v)
      for (std::size_t c = 0; c < 3; ++c)
        vertex_albedo_[v][c] = appearance.base_color[c] * (pack.colors.empty() ? 1 : pack.colors[v][c]);
  }
  projected_.assign(mesh_.vertexCount() * components_, Float3{0, 0, 0});
  if (!pack.sh().glossy->isInObjectFrame()) return;
  local_from_object_.reserve(mesh_.vertexCount());
  for (std::size_t v = 0; v < mesh_.vertexCount(); ++v)
    local_from_object_.emplace_back(output_order, localFrame(mesh_.normals[v], tangents_[v]));
}

LightNeeds BiScaleShading::needs() const {
  return {order_};
}

void BiScaleShading::setLight(std::span<const Float3> distant, std::span<const Float3> near) {
  const std::size_t count = coefficientCount(order_);
  if (distant.size() < count || (!near.empty() && near.size() < count))
    throw std::invalid_argument("the light has fewer bands than the pack");
  ShLight light(distant.begin(), distant.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t i = 0; i < count && !near.empty(); ++i)
    for (std::size_t c = 0; c < 3; ++c) light[i][c] += near[i][c];
  project(transfer_->transferredRadiance(light));
}

void BiScaleShading::project(std::span<const Float3> transferred) {
  for (std::size_t a = 0; a < ranges_.size(); ++a) {
    const RttReflection& reflection = patches_[a]->reflection;
    const std::size_t count = coefficientCount(reflection.order);
    tbb::parallel_for(ranges_[a].first, ranges_[a].end, [&](std::size_t v) {
      std::span<const Float3> incident = transferred.subspan(v * rows_, rows_);
      std::vector<Float3> turned;
      if (!local_from_object_.empty()) incident = turned = local_from_object_[v].apply(incident);
      for (int k = 0; k < reflection.components; ++k) {
        const float* basis = reflection.basisOf(k);
        Float3& sum = projected_[v * components_ + static_cast<std::size_t>(k)];
        for (std::size_t c = 0; c < 3; ++c) {
          double product = 0;
          for (std::size_t i = 0; i < count; ++i) product += double{basis[c * count + i]} * incident[i][c];
          sum[c] = static_cast<float>(product) * vertex_albedo_[v][c];
        }
      }
    });
  }
}

Float3 BiScaleShading::radianceAt(const SurfaceHit& hit) const {
  const SeenPoint at = seenPoint(mesh_, tangents_, hit, cornerWeights(hit), view_.eye);
  const Patch& patch = *patches_[at.appearance];
  std::array<float, 3 * formats::kMaxOrder * formats::kMaxOrder> buffer;
  const std::span<float> factors = std::span(buffer).first(patch.lookup.components());
  patch.lookup.factorsAt(at, view_.pixel_angle, factors);
  Float3 radiance = {0, 0, 0};
  for (std::size_t k = 0; k < factors.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      float incident = 0;
      for (std::size_t corner = 0; corner < 3; ++corner)
        incident += at.weights[corner] * projected_[at.corners[corner] * components_ + k][c];
      radiance[c] += factors[k] * incident;
    }
  return radiance;
}

void BiScaleShading::radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const {
  for (std::size_t i = 0; i < hits.size(); ++i) radiance[i] = radianceAt(hits[i]);
}

}  // namespace bakelight::transport
