#include "transport/microfacet.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kAngles = 129;
constexpr int kLatticePoints = 1 << 13;
// Less than that is lost between facets is rounding.
constexpr double kSmallestLoss = 1e-9;

double fifthPower(double x) {
  const double square = x * x;
  return square * square * x;
}

}  // namespace

Microfacets::Microfacets(const Vec3& specular_color, double roughness, bool fresnel, bool multiple_scattering)
    : specular_color_(specular_color),
      alpha_(roughness * roughness),
      fresnel_(fresnel),
      mirror_(roughness < kMirrorRoughness) {
  if (mirror_ || !multiple_scattering) return;
  std::vector<double> cosines;
  for (std::size_t i = 0; i < kAngles; ++i) {
    const double root = static_cast<double>(i) / (kAngles - 1);
    cosines.push_back(root * root);
    albedo_.push_back(integratedAlbedo(cosines.back()));
  }
  // Of the same piecewise linear function that singleAlbedo is, so that no light is made or lost.
  mean_albedo_ = 0;
  for (std::size_t i = 0; i + 1 < kAngles; ++i) {
    const double a = cosines[i], b = cosines[i + 1];
    mean_albedo_ += (b - a) / 3 * (albedo_[i] * (2 * a + b) + albedo_[i + 1] * (a + 2 * b));
  }
  // The mean of a facet's reflectance over cosine-weighted angles, and the series of its powers.
  const Vec3 facet = fresnel ? Vec3((20 * specular_color + Vec3::Ones()) / 21) : specular_color;
  multiple_color_ =
      facet.unaryExpr([this](double f) { return f * f * mean_albedo_ / (1 - f * (1 - mean_albedo_)); });
}

Vec3 Microfacets::facetReflectance(double cosine) const {
  if (!fresnel_) return specular_color_;
  return specular_color_ + (Vec3::Ones() - specular_color_) * fifthPower(1 - std::clamp(cosine, 0.0, 1.0));
}

double Microfacets::distribution(const Vec3& half) const {
  const double alpha2 = alpha_ * alpha_;
  // 1 − (1 − α²) cos²; the sine is exact near the peak, where the difference is not.
  const double fall = half.x() * half.x() + half.y() * half.y() + alpha2 * half.z() * half.z();
  return alpha2 / (kPi * fall * fall);
}

double Microfacets::slopeTerm(double cosine) const {
  const double alpha2 = alpha_ * alpha_;
  return std::sqrt(alpha2 + (1 - alpha2) * cosine * cosine);
}

Vec3 Microfacets::singleScattering(const Vec3& incident, const Vec3& outgoing) const {
  const double in = incident.z(), out = outgoing.z();
  if (in < 0 || out < 0) return Vec3::Zero();
  const Vec3 half = (incident + outgoing).normalized();
  // Masking and shadowing over 4 cos cos, finite at grazing angles but where both graze.
  const double smith = out * slopeTerm(in) + in * slopeTerm(out);
  return facetReflectance(half.dot(incident)) * (distribution(half) * 0.5 / std::max(smith, 1e-300));
}

Vec3 Microfacets::multipleScattering(double cosine_in, double cosine_out) const {
  if (albedo_.empty() || cosine_in < 0 || cosine_out < 0 || 1 - mean_albedo_ < kSmallestLoss)
    return Vec3::Zero();
  return multiple_color_ *
         ((1 - singleAlbedo(cosine_in)) * (1 - singleAlbedo(cosine_out)) / (kPi * (1 - mean_albedo_)));
}

Vec3 Microfacets::brdf(const Vec3& incident, const Vec3& outgoing) const {
  return singleScattering(incident, outgoing) + multipleScattering(incident.z(), outgoing.z());
}

Vec3 Microfacets::sampleIncident(const Vec3& outgoing, double u, double v) const {
  // The hemisphere of which the facets are a stretched one, seen from where the eye is then.
  const Vec3 eye = Vec3(alpha_ * outgoing.x(), alpha_ * outgoing.y(), outgoing.z()).normalized();
  const double flat = eye.x() * eye.x() + eye.y() * eye.y();
  const Vec3 across = flat > 0 ? Vec3(Vec3(-eye.y(), eye.x(), 0) / std::sqrt(flat)) : Vec3::UnitX();
  const Vec3 along = eye.cross(across);
  // A point of its outline: half a disk and half an ellipse.
  const double radius = std::sqrt(u), turn = 2 * kPi * v;
  const double x = radius * std::cos(turn), share = (1 + eye.z()) / 2;
  const double y = (1 - share) * std::sqrt(std::max(0.0, 1 - x * x)) + share * radius * std::sin(turn);
  const Vec3 normal = x * across + y * along + std::sqrt(std::max(0.0, 1 - x * x - y * y)) * eye;
  const Vec3 half = Vec3(alpha_ * normal.x(), alpha_ * normal.y(), std::max(0.0, normal.z())).normalized();
  return 2 * outgoing.dot(half) * half - outgoing;
}

double Microfacets::densityPerSr(const Vec3& incident, const Vec3& outgoing) const {
  if (incident.z() <= 0) return 0;
  const Vec3 half = (incident + outgoing).normalized();
  // G1 D / (4 cos), with the cosine cancelled out.
  return distribution(half) / (2 * (outgoing.z() + slopeTerm(outgoing.z())));
}

double Microfacets::singleAlbedo(double cosine) const {
  const double place = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (kAngles - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), kAngles - 2);
  const double step = kAngles - 1, low = static_cast<double>(below) / step,
               high = static_cast<double>(below + 1) / step;
  const double share = (std::clamp(cosine, 0.0, 1.0) - low * low) / (high * high - low * low);
  return (1 - share) * albedo_[below] + share * albedo_[below + 1];
}

// Mean of value ÷ density of the samples of a lattice, shadowing over masking: no facet's own reflectance.
double Microfacets::integratedAlbedo(double cosine) const {
  const Vec3 outgoing(std::sqrt(std::max(0.0, 1 - cosine * cosine)), 0, cosine);
  double sum = 0;
  for (int i = 0; i < kLatticePoints; ++i) {
    const double v = i * std::numbers::phi;
    const Vec3 incident = sampleIncident(outgoing, (i + 0.5) / kLatticePoints, v - std::floor(v));
    const double in = incident.z();
    if (in <= 0) continue;
    sum +=
        in * (cosine + slopeTerm(cosine)) / std::max(cosine * slopeTerm(in) + in * slopeTerm(cosine), 1e-300);
  }
  return sum / kLatticePoints;
}

}  // namespace bakelight::transport
