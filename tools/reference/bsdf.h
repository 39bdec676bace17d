// How a surface point reflects: the player's materials (docs/RUNTIME.md) without spherical harmonics, except
// for BRDF tables, which are made of them.
#pragma once

#include <vector>

#include "formats/pack_contents.h"
#include "transport/distant_light_sampler.h"

namespace bakelight::reference {

using transport::Rgb;
using transport::Vec3;

// A normalised lobe around the reflection direction, ∫ K = 1 over the sphere.
//   Phong: (s + 1)/2π · cos^s over the hemisphere around it.
//   GGX: D(θ/2) · cos θ, α = roughness², seen from above: K ∝ (1 − u)/(1 + bu)² with u = 1 − cos θ ≤ 1 and
// b = (1 − α²)/2α², whose integral (b+1)(1 − 1/t) − ln t, t = 1 + bu, is inverted by Newton's method.
class Lobe {
 public:
  static Lobe phong(double exponent);
  // Roughness below 1e-6 is a mirror.
  static Lobe ggx(double roughness);

  bool isMirror() const { return kind_ == Kind::kMirror; }
  // K at this cosine to the reflection direction, in 1/sr. Not for a mirror.
  double valuePerSr(double cosine) const;
  // 1 − cos θ of K's distribution at `number` in [0, 1).
  double sampleOneMinusCosine(double number) const;

 private:
  enum class Kind { kPhong, kGgx, kMirror };
  Lobe(Kind kind, double parameter);

  Kind kind_;
  double parameter_;     // exponent, or b
  double ggx_norm_ = 1;  // ∫₀¹ (1 − u)/(1 + bu)² du
};

// All that does not change over a surface.
class Material {
 public:
  explicit Material(const formats::PackPart& reflection);

  const formats::BrdfTable* table() const { return table_.order > 0 ? &table_ : nullptr; }
  const Lobe* lobe() const { return has_lobe_ ? &lobe_ : nullptr; }
  const Rgb& specularColor() const { return specular_color_; }

 private:
  bool has_lobe_ = false;
  Lobe lobe_;
  Rgb specular_color_ = Rgb::Zero();
  formats::BrdfTable table_;  // order 0 without
};

// Reflection at one point towards one direction. Radiance towards the eye is ∫ value(s) L(s) ds over the
// hemisphere around the normal: a cosine is inside where there is one.
class Bsdf {
 public:
  // `outgoing` is unit; below the surface it counts as mirrored above it. `glossy`: with lobe or table, else
  // the diffuse part alone.
  Bsdf(const Material& material, const Rgb& albedo, const Vec3& normal, const Vec3& outgoing, bool glossy);

  // Per steradian; zero below the surface. Without a mirror's delta.
  Rgb value(const Vec3& incoming) const;
  double densityPerSr(const Vec3& incoming) const;  // of sample()

  struct Sample {
    Vec3 incoming;
    Rgb weight;             // value ÷ density
    double density_per_sr;  // 0 for a mirror's direction
  };
  // By reflected power of diffuse part and lobe, each by its own distribution. Black surfaces and directions
  // below the surface have weight 0.
  Sample sample(double choice, double u, double v) const;
  // The same integral by directions uniform over the hemisphere (a mirror's but for its own).
  Sample sampleUniformly(double choice, double u, double v) const;

 private:
  Rgb tableValue(const Vec3& incoming) const;
  Sample mirrorSample() const;

  Rgb albedo_;
  Vec3 normal_, tangent_, bitangent_, reflection_;
  const Lobe* lobe_ = nullptr;
  Rgb specular_color_ = Rgb::Zero();
  double diffuse_share_ = 1;        // of samples
  std::vector<double> table_rows_;  // 3 × order²; empty without
  int table_order_ = 0;
};

}  // namespace bakelight::reference
