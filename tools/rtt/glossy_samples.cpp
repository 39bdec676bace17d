#include "tools/rtt/glossy_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "transport/glossy.h"
#include "transport/random.h"
#include "transport/sh.h"

namespace bakelight::rtt {
namespace {

using transport::StratifiedBatch;
constexpr double kPi = std::numbers::pi;

// Columns: a tangent, a bitangent, the normal.
Eigen::Matrix3d frameAround(const Vec3& normal) {
  Eigen::Matrix3d frame;
  frame.col(0) = normal.unitOrthogonal();
  frame.col(1) = normal.cross(frame.col(0));
  frame.col(2) = normal;
  return frame;
}

Vec3 around(double cosine, double turn) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return {sine * std::cos(turn), sine * std::sin(turn), cosine};
}

// Of all directions in the local frame above the surface; each weighs what it weighs ÷ its density.
struct LocalSample {
  Vec3 incoming, weight;
};

LocalSample phongSample(const Vec3& color, double exponent, const Vec3& eye, double u, double v) {
  const Vec3 mirrored(-eye.x(), -eye.y(), eye.z());
  const double cosine = std::pow(1 - u, 1 / (exponent + 1));
  return {frameAround(mirrored) * around(cosine, 2 * kPi * v), color};
}

// What scatters several times between facets is nearly diffuse and sampled so, by its share of what is reflected.
LocalSample facetSample(const transport::Microfacets& facets, const Vec3& eye, double choice, double u,
                        double v) {
  double diffuse_share = 0;
  if (facets.scattersMultiply()) diffuse_share = std::clamp(1 - facets.singleAlbedo(eye.z()), 0.0, 1.0);
  const bool is_diffuse = choice < diffuse_share;
  const Vec3 incoming = is_diffuse ? around(std::sqrt(1 - u), 2 * kPi * v) : facets.sampleIncident(eye, u, v);
  if (incoming.z() <= 0) return {incoming, Vec3::Zero()};
  const double density =
      diffuse_share * incoming.z() / kPi + (1 - diffuse_share) * facets.densityPerSr(incoming, eye);
  if (!(density > 0)) return {incoming, Vec3::Zero()};
  return {incoming, facets.brdf(incoming, eye) * (incoming.z() / density)};
}

LocalSample tableSample(std::span<const double> rows, int order, double u, double v) {
  const Vec3 incoming = around(std::sqrt(1 - u), 2 * kPi * v);
  std::array<double, transport::kMaxEvaluatedOrder * transport::kMaxEvaluatedOrder> basis;
  const auto count = static_cast<std::size_t>(transport::coefficientCount(order));
  transport::evaluateSh(order, incoming, std::span(basis).first(count));
  Vec3 value = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < count; ++i)
      value[static_cast<Eigen::Index>(c)] += rows[c * count + i] * basis[i];
  return {incoming, value * (kPi / std::max(incoming.z(), 1e-6))};
}

}  // namespace

GlossyReflection::GlossyReflection(const formats::Reflection& reflection) {
  if (const auto* phong = std::get_if<formats::PhongReflection>(&reflection))
    kind_ = Phong{transport::vec3(phong->specular_color), phong->exponent};
  if (const auto* ggx = std::get_if<formats::GgxReflection>(&reflection))
    kind_ = transport::Microfacets(transport::vec3(ggx->specular_color), ggx->roughness, ggx->fresnel,
                                   ggx->multiple_scattering);
  if (const auto* table = std::get_if<formats::TableReflection>(&reflection)) kind_ = table->table;
}

int GlossyReflection::sampleCount(int wanted) const {
  const auto* facets = std::get_if<transport::Microfacets>(&kind_);
  if (isNone()) return 0;
  if (facets != nullptr && facets->isMirror()) return 1;
  return (wanted + StratifiedBatch::kSize - 1) / StratifiedBatch::kSize * StratifiedBatch::kSize;
}

void GlossyReflection::sample(const Vec3& normal, const Vec3& view, int count, std::uint64_t element,
                              std::vector<GlossySample>& samples) const {
  const Eigen::Matrix3d frame = frameAround(normal);
  Vec3 eye = frame.transpose() * view;
  eye.z() = std::max(std::abs(eye.z()), 1e-4);
  eye.normalize();
  const auto* phong = std::get_if<Phong>(&kind_);
  const auto* facets = std::get_if<transport::Microfacets>(&kind_);
  const auto* table = std::get_if<formats::BrdfTable>(&kind_);
  if (facets != nullptr && facets->isMirror()) {
    samples.push_back({frame * Vec3(-eye.x(), -eye.y(), eye.z()), facets->facetReflectance(eye.z())});
    return;
  }
  std::vector<double> rows;
  if (table != nullptr) {
    rows.resize(3 * static_cast<std::size_t>(transport::coefficientCount(table->order)));
    transport::tableRows(*table, eye, table->order, rows);
  }
  for (int i = 0; i < count; ++i) {
    const StratifiedBatch batch(0, element, static_cast<std::uint64_t>(i / StratifiedBatch::kSize));
    const auto [u, v] = batch.pair(i % StratifiedBatch::kSize, 0);
    const LocalSample local =
        phong != nullptr    ? phongSample(phong->color, phong->exponent, eye, u, v)
        : facets != nullptr ? facetSample(*facets, eye, batch.single(i % StratifiedBatch::kSize, 1), u, v)
                            : tableSample(rows, table->order, u, v);
    if (local.incoming.z() > 0) samples.push_back({frame * local.incoming, local.weight});
  }
}

}  // namespace bakelight::rtt
