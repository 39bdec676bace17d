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

using formats::Float2;
using formats::Float4;
using formats::PackImage;
using formats::RttReflection;

bool isLambert(const formats::Appearance& appearance) {
  return appearance.reflection.as<formats::LambertReflection>() != nullptr;
}

Eigen::Matrix3d localFromObject(const Float3& normal, const Float4& tangent) {
  const Vec3 n = vec3(normal).normalized(), along(tangent[0], tangent[1], tangent[2]);
  Eigen::Matrix3d local;
  local.row(0) = (along - along.dot(n) * n).normalized();
  local.row(2) = n;
  local.row(1) = tangent[3] * n.cross(Vec3(local.row(0)));
  return local;
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

double rttLevelOf(double distance, double pixel_angle, double cosine, double texel_width) {
  const double covered = distance * pixel_angle / (texel_width * std::sqrt(std::max(cosine, 0.01)));
  return covered > 1 ? std::log2(covered) : 0;
}

RttLevels rttLevelsAt(double level, std::size_t count) {
  level = std::min(level, static_cast<double>(count - 1));
  const auto fine = static_cast<std::size_t>(level);
  constexpr double kFirst = 0.35, kLast = 0.65;
  const double blend = std::clamp((level - static_cast<double>(fine) - kFirst) / (kLast - kFirst), 0.0, 1.0);
  if (blend >= 1) return {fine + 1, 0};
  return {fine, static_cast<float>(blend)};
}

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
    const RttReflection reflection = rtt == nullptr ? flatReflection(output_order) : *rtt;
    if (reflection.basis.size() !=
        3 * static_cast<std::size_t>(reflection.components) * coefficientCount(reflection.order))
      throw std::invalid_argument("the basis of a radiance transfer texture does not fit its order");
    tables_.emplace_back(reflection, rtt == nullptr ? nullptr : indices[i]);
    bases_.push_back({reflection.order, reflection.basis});
    components_ = std::max(components_, tables_.back().componentCount());
    if (reflection.order > output_order)
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
    local_from_object_.emplace_back(output_order, localFromObject(mesh_.normals[v], tangents_[v]));
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
    const Basis& bases = bases_[a];
    const std::size_t count = coefficientCount(bases.order);
    tbb::parallel_for(ranges_[a].first, ranges_[a].end, [&](std::size_t v) {
      std::span<const Float3> incident = transferred.subspan(v * rows_, rows_);
      std::vector<Float3> turned;
      if (!local_from_object_.empty()) incident = turned = local_from_object_[v].apply(incident);
      for (std::size_t k = 0; k < tables_[a].componentCount(); ++k) {
        const float* basis = &bases.values[k * 3 * count];
        Float3& sum = projected_[v * components_ + k];
        for (std::size_t c = 0; c < 3; ++c) {
          double product = 0;
          for (std::size_t i = 0; i < count; ++i) product += double{basis[c * count + i]} * incident[i][c];
          sum[c] = static_cast<float>(product) * vertex_albedo_[v][c];
        }
      }
    });
  }
}

struct BiScaleShading::Surface {
  std::size_t appearance = 0;
  formats::Triangle corners = {};
  std::array<float, 3> weights = {};
  Float2 texcoord = {0, 0};
  Vec3 to_eye;  // local
  double distance = 0;
};

BiScaleShading::Surface BiScaleShading::surfaceAt(const SurfaceHit& hit) const {
  Surface at;
  at.corners = mesh_.triangles[hit.triangle];
  at.weights = {1 - hit.u - hit.v, hit.u, hit.v};
  if (!mesh_.triangle_materials.empty()) at.appearance = mesh_.triangle_materials[hit.triangle];
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero(), tangent = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = at.corners[k];
    const double weight = at.weights[k];
    position += weight * vec3(mesh_.positions[v]);
    normal += weight * vec3(mesh_.normals[v]);
    tangent += weight * Vec3(tangents_[v][0], tangents_[v][1], tangents_[v][2]);
    if (mesh_.texcoords.empty()) continue;
    for (std::size_t c = 0; c < 2; ++c) at.texcoord[c] += at.weights[k] * mesh_.texcoords[v][c];
  }
  const Float3 t = float3(tangent);
  const Vec3 offset = view_.eye - position;
  at.distance = offset.norm();
  if (at.distance > 0 && normal.norm() > 0)
    at.to_eye = localFromObject(float3(normal), {t[0], t[1], t[2], tangents_[at.corners[0]][3]}) *
                (offset / at.distance);
  else
    at.to_eye = Vec3::UnitZ();
  return at;
}

Float3 BiScaleShading::radianceAt(const SurfaceHit& hit) const {
  const Surface at = surfaceAt(hit);
  const PatchTable& patch = tables_[at.appearance];
  const RttLevels levels =
      rttLevelsAt(rttLevelOf(at.distance, view_.pixel_angle, at.to_eye.z(), double{patch.texelWidth()}),
                  patch.levels().size());
  std::array<float, 3 * formats::kMaxOrder * formats::kMaxOrder> buffer;
  const std::span<float> factors = std::span(buffer).first(patch.componentCount());
  std::fill(factors.begin(), factors.end(), 0.0F);
  const formats::RttLevel& fine = patch.levels()[levels.fine];
  for (const PatchTable::View& view : patch.viewsAt(fine, patch.placeOf(at.texcoord), at.to_eye)) {
    if (view.weight <= 0) continue;
    patch.add(fine, view, view.weight * (1 - levels.blend), factors);
    if (levels.blend > 0)
      patch.add(patch.levels()[levels.fine + 1], view, view.weight * levels.blend, factors);
  }
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
