// How a surface point reflects: physically, or as the player does (docs/RUNTIME.md) without spherical
// harmonics, except for BRDF tables, which are made of them.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/material.h"
#include "formats/words.h"
#include "tools/reference/distant_light_sampler.h"
#include "transport/microfacet.h"

namespace bakelight::reference {

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

// What a material's reflection is taken for.
enum class ReflectionModel {
  kPhysical,  // GGX: microfacets
  kLobe,      // GGX: the player's lobe around the mirror direction
  kTable,     // a table of the tool brdf
  kNone       // left out: the diffuse part alone
};
inline constexpr formats::Word<ReflectionModel> kReflectionModels[] = {
    {"physical", ReflectionModel::kPhysical},
    {"lobe", ReflectionModel::kLobe},
    {"table", ReflectionModel::kTable},
    {"none", ReflectionModel::kNone}};

struct TintedLobe {
  Lobe lobe;
  Rgb color;
};

// What a surface has besides its diffuse part; nothing, or one of these. Phong is its lobe in all models, and
// a reflection that is a table stays that one.
using Glossy = std::variant<std::monostate, TintedLobe, transport::Microfacets, formats::BrdfTable>;
// `table`: with kTable, for reflections that are none themselves; null without. Throws Error(kBadInput) if it is missing.
Glossy glossyOf(const formats::Reflection& reflection, ReflectionModel model,
                const formats::BrdfTable* table);

// Reflection at one point towards one direction. Radiance towards the eye is ∫ value(s) L(s) ds over the
// hemisphere around the normal: a cosine is inside where there is one.
class Bsdf {
 public:
  // `outgoing` is unit; below the surface it counts as mirrored above it. Keeps a reference to `glossy`;
  // null: the diffuse part alone.
  Bsdf(const Glossy* glossy, const Rgb& albedo, const Vec3& normal, const Vec3& outgoing);

  // What lights from above send into a medium: value() is the cosine times Schlick's transmittance.
  static Bsdf entering(double relative_ior, const Vec3& normal);

  // The same exactly, shared out so that a uniform light of 1 sends 1 in: the cosine times Fresnel's transmittance ÷ π ÷ its mean
  // `diffuse_transmittance` over such light.
  static Bsdf enteringDiffusely(double relative_ior, double diffuse_transmittance, const Vec3& normal);

  // Per steradian; zero below the surface. Without a mirror's delta.
  Rgb value(const Vec3& incoming) const;
  double densityPerSr(const Vec3& incoming) const;  // of sample()

  struct Sample {
    Vec3 incoming;
    Rgb weight;             // value ÷ density
    double density_per_sr;  // 0 for a mirror's direction
  };
  // By reflected power of diffuse part (with what facets scatter several times) and lobe or facets, each by
  // its own distribution. Black surfaces and directions below the surface have weight 0.
  Sample sample(double choice, double u, double v) const;
  // The same integral by directions uniform over the hemisphere (a mirror's but for its own).
  Sample sampleUniformly(double choice, double u, double v) const;

 private:
  Vec3 local(const Vec3& direction) const;
  Vec3 world(const Vec3& local) const;
  bool isMirror() const;
  Rgb glossyValue(const Vec3& incoming) const;  // with the cosine; without a mirror's delta
  double glossyDensity(const Vec3& incoming) const;
  Rgb tableValue(const Vec3& incoming) const;
  Sample mirrorSample() const;
  // Of the glossy part: its own reflectance, and that of what it scatters like a diffuse one, seen from here.
  struct Power {
    Rgb glossy = Rgb::Zero(), diffuse = Rgb::Zero();
  };
  Power power() const;

  Rgb albedo_;
  Vec3 normal_, tangent_, bitangent_, reflection_;
  Vec3 local_eye_;  // above the surface
  const TintedLobe* lobe_ = nullptr;
  const transport::Microfacets* facets_ = nullptr;
  double diffuse_share_ = 1;        // of samples
  double entered_ior_ = 0;          // of what is entered; 0: nothing is
  bool schlick_ = true;             // how it is entered
  std::vector<double> table_rows_;  // 3 × order²; empty without
  int table_order_ = 0;
};

}  // namespace bakelight::reference
