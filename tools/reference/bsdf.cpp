#include "tools/reference/bsdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/error.h"
#include "transport/diffusion.h"
#include "transport/glossy.h"
#include "transport/sh.h"

namespace bakelight::reference {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMirrorRoughness = 1e-6;

double luminanceOf(const Rgb& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// ∫₀ᵘ (1 − x)/(1 + bx)² dx. Below b = 0.1 by its series, since the closed form cancels there.
double ggxIntegral(double u, double b) {
  if (b < 0.1) {
    // (1 + bx)^−2 = Σ (−1)^k (k+1) b^k x^k
    double sum = 0, power = u, factor = 1;
    for (int k = 0; k < 24; ++k) {
      sum += factor * (k + 1) * power * (1.0 / (k + 1) - u / (k + 2));
      power *= u;
      factor *= -b;
    }
    return sum;
  }
  const double t = 1 + b * u;
  return ((b + 1) * b * u / t - std::log1p(b * u)) / (b * b);
}

double ggxFall(double u, double b) {
  const double t = 1 + b * u;
  return (1 - u) / (t * t);
}

}  // namespace

Lobe::Lobe(Kind kind, double parameter) : kind_(kind), parameter_(parameter) {
  if (kind == Kind::kGgx) ggx_norm_ = ggxIntegral(1, parameter);
}

Lobe Lobe::phong(double exponent) {
  return {Kind::kPhong, exponent};
}

Lobe Lobe::ggx(double roughness) {
  if (roughness < kMirrorRoughness) return {Kind::kMirror, 0};
  const double alpha_squared = std::pow(roughness, 4);
  return {Kind::kGgx, (1 - alpha_squared) / (2 * alpha_squared)};
}

double Lobe::valuePerSr(double cosine) const {
  if (cosine <= 0) return 0;
  if (kind_ == Kind::kPhong) return (parameter_ + 1) / (2 * kPi) * std::pow(cosine, parameter_);
  return ggxFall(1 - cosine, parameter_) / (2 * kPi * ggx_norm_);
}

double Lobe::sampleOneMinusCosine(double number) const {
  if (kind_ == Kind::kPhong) return 1 - std::pow(1 - number, 1 / (parameter_ + 1));
  // Newton's method within a bracket. The start ignores the factor 1 − u, which matters in the tail only.
  const double b = parameter_, target = number * ggx_norm_;
  double low = 0, high = 1;
  double u = number / (1 + b * (1 - number));
  for (int i = 0; i < 60; ++i) {
    const double error = ggxIntegral(u, b) - target;
    (error > 0 ? high : low) = u;
    const double slope = ggxFall(u, b);
    double next = slope > 0 ? u - error / slope : low;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (std::abs(next - u) <= 1e-12 * u) return next;
    u = next;
  }
  return u;
}

Glossy glossyOf(const formats::Reflection& reflection, ReflectionModel model,
                const formats::BrdfTable* table) {
  if (model == ReflectionModel::kNone || std::holds_alternative<formats::Lambert>(reflection)) return {};
  const auto* own = std::get_if<formats::TableReflection>(&reflection);
  if (model == ReflectionModel::kTable && own == nullptr) {
    if (table == nullptr)
      throw badInput({"", "", "/reflection"}, "a table needs a projected BRDF", "a file of the brdf tool",
                     "give it as input brdf");
    return *table;
  }
  if (own != nullptr) return own->table;
  const auto* ggx = std::get_if<formats::GgxReflection>(&reflection);
  if (ggx != nullptr && model == ReflectionModel::kPhysical)
    return transport::Microfacets(transport::vec3(ggx->specular_color), ggx->roughness, ggx->fresnel,
                                  ggx->multiple_scattering);
  const formats::PackPart lobe = formats::runtimeLobe(reflection);
  if (const auto* phong = lobe.as<formats::PhongLobe>())
    return TintedLobe{Lobe::phong(phong->exponent), transport::vec3(phong->specular_color)};
  if (const auto* symmetric = lobe.as<formats::GgxLobe>())
    return TintedLobe{Lobe::ggx(symmetric->roughness), transport::vec3(symmetric->specular_color)};
  return {};
}

Bsdf::Bsdf(const Glossy* glossy, const Rgb& albedo, const Vec3& normal, const Vec3& outgoing)
    : albedo_(albedo), normal_(normal) {
  // Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
  const double sign = std::copysign(1.0, normal.z()), a = -1 / (sign + normal.z());
  const double b = normal.x() * normal.y() * a;
  tangent_ = Vec3(1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x());
  bitangent_ = Vec3(b, sign + normal.y() * normal.y() * a, -normal.y());
  if (glossy == nullptr) return;

  lobe_ = std::get_if<TintedLobe>(glossy);
  facets_ = std::get_if<transport::Microfacets>(glossy);
  if (lobe_ != nullptr || facets_ != nullptr) {
    const double cosine = normal.dot(outgoing);
    reflection_ = (cosine + std::abs(cosine)) * normal - outgoing;
    local_eye_ = local(outgoing);
    local_eye_.z() = std::abs(local_eye_.z());
    const Power reflected = power();
    const double diffuse = luminanceOf(albedo + reflected.diffuse), specular = luminanceOf(reflected.glossy);
    diffuse_share_ = diffuse + specular > 0 ? diffuse / (diffuse + specular) : 1;
  }
  if (const auto* table = std::get_if<formats::BrdfTable>(glossy)) {
    table_order_ = table->order;
    table_rows_.resize(3 * transport::coefficientCount(table->order));
    transport::tableRows(*table, local(outgoing), table->order, table_rows_);
  }
}

Bsdf Bsdf::entering(double relative_ior, const Vec3& normal) {
  Bsdf bsdf(nullptr, Rgb::Constant(kPi), normal, normal);
  bsdf.entered_ior_ = relative_ior;
  return bsdf;
}

Bsdf Bsdf::enteringDiffusely(double relative_ior, double diffuse_transmittance, const Vec3& normal) {
  Bsdf bsdf(nullptr, Rgb::Constant(1 / diffuse_transmittance), normal, normal);
  bsdf.entered_ior_ = relative_ior;
  bsdf.schlick_ = false;
  return bsdf;
}

Vec3 Bsdf::local(const Vec3& direction) const {
  return {tangent_.dot(direction), bitangent_.dot(direction), normal_.dot(direction)};
}

Vec3 Bsdf::world(const Vec3& local) const {
  return local.x() * tangent_ + local.y() * bitangent_ + local.z() * normal_;
}

bool Bsdf::isMirror() const {
  return lobe_ != nullptr ? lobe_->lobe.isMirror() : facets_ != nullptr && facets_->isMirror();
}

Bsdf::Power Bsdf::power() const {
  if (lobe_ != nullptr) return {lobe_->color, Rgb::Zero()};
  const Rgb facet = facets_->facetReflectance(local_eye_.z());
  if (!facets_->scattersMultiply()) return {facet, Rgb::Zero()};
  const double single = std::min(facets_->singleAlbedo(local_eye_.z()), 1.0);
  return {single * facet, (1 - single) * facets_->multipleColor().array()};
}

Rgb Bsdf::value(const Vec3& incoming) const {
  const double cosine = normal_.dot(incoming);
  if (cosine <= 0) return Rgb::Zero();
  Rgb value = albedo_ * (cosine / kPi);
  if (entered_ior_ > 0)
    value *= schlick_ ? transport::schlickTransmittance(cosine, entered_ior_)
                      : 1 - transport::fresnelReflectance(cosine, entered_ior_);
  if (!isMirror()) value += glossyValue(incoming);
  if (!table_rows_.empty()) value += tableValue(incoming);
  return value;
}

Rgb Bsdf::glossyValue(const Vec3& incoming) const {
  if (lobe_ != nullptr) return lobe_->color * lobe_->lobe.valuePerSr(reflection_.dot(incoming));
  if (facets_ == nullptr) return Rgb::Zero();
  const Vec3 from = local(incoming);
  return facets_->brdf(from, local_eye_).array() * from.z();
}

double Bsdf::glossyDensity(const Vec3& incoming) const {
  if (lobe_ != nullptr) return lobe_->lobe.valuePerSr(reflection_.dot(incoming));
  return facets_ == nullptr ? 0 : facets_->densityPerSr(local(incoming), local_eye_);
}

Rgb Bsdf::tableValue(const Vec3& incoming) const {
  std::array<double, transport::kMaxEvaluatedOrder * transport::kMaxEvaluatedOrder> basis;
  const auto count = static_cast<std::size_t>(transport::coefficientCount(table_order_));
  transport::evaluateSh(table_order_, local(incoming), std::span(basis).first(count));
  Rgb value = Rgb::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < count; ++i)
      value[static_cast<Eigen::Index>(c)] += table_rows_[c * count + i] * basis[i];
  return value;
}

double Bsdf::densityPerSr(const Vec3& incoming) const {
  const double cosine = normal_.dot(incoming);
  if (cosine <= 0) return 0;
  double density = diffuse_share_ * cosine / kPi;
  if (!isMirror()) density += (1 - diffuse_share_) * glossyDensity(incoming);
  return density;
}

Bsdf::Sample Bsdf::mirrorSample() const {
  // The reflection of a grazing eye is never below the surface, except by a rounding.
  const Rgb reflected = lobe_ != nullptr ? lobe_->color : Rgb(facets_->facetReflectance(local_eye_.z()));
  return {reflection_, reflected / (1 - diffuse_share_), 0};
}

Bsdf::Sample Bsdf::sample(double choice, double u, double v) const {
  Sample sample;
  const double turn = 2 * kPi * v;
  if (choice < diffuse_share_) {
    const double radius = std::sqrt(u);
    sample.incoming = radius * std::cos(turn) * tangent_ + radius * std::sin(turn) * bitangent_ +
                      std::sqrt(std::max(0.0, 1 - u)) * normal_;
  } else if (isMirror()) {
    return mirrorSample();
  } else if (facets_ != nullptr) {
    sample.incoming = world(facets_->sampleIncident(local_eye_, u, v));
  } else {
    const double drop = lobe_->lobe.sampleOneMinusCosine(u),
                 sine = std::sqrt(std::max(0.0, drop * (2 - drop)));
    const Vec3 right = reflection_.unitOrthogonal(), up = reflection_.cross(right);
    sample.incoming = (1 - drop) * reflection_ + sine * (std::cos(turn) * right + std::sin(turn) * up);
  }
  sample.density_per_sr = densityPerSr(sample.incoming);
  sample.weight =
      sample.density_per_sr > 0 ? Rgb(value(sample.incoming) / sample.density_per_sr) : Rgb(Rgb::Zero());
  return sample;
}

Bsdf::Sample Bsdf::sampleUniformly(double choice, double u, double v) const {
  const bool has_mirror = isMirror();
  if (has_mirror && choice >= diffuse_share_) return mirrorSample();
  const double share = has_mirror ? diffuse_share_ : 1, radius = std::sqrt(u * (2 - u)), turn = 2 * kPi * v;
  Sample sample;
  sample.incoming =
      radius * std::cos(turn) * tangent_ + radius * std::sin(turn) * bitangent_ + (1 - u) * normal_;
  sample.density_per_sr = share / (2 * kPi);
  sample.weight = value(sample.incoming) / sample.density_per_sr;
  return sample;
}

}  // namespace bakelight::reference
