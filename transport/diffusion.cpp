#include "transport/diffusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "transport/gauss_legendre.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;

// (1 − e^{−x t}) / x, which is t for x = 0.
double decayed(double x, double t) {
  return x * t < 1e-300 ? t : -std::expm1(-x * t) / x;
}

void requireUsable(const ScatteringCoefficients& c) {
  const bool finite = std::isfinite(c.reduced_scattering) && std::isfinite(c.absorption);
  if (!finite || c.reduced_scattering <= 0 || c.absorption < 0)
    throw std::invalid_argument("a medium scatters (σs′ > 0) and does not amplify (σa ≥ 0)");
  if (!(c.relative_ior >= 1 && c.relative_ior <= 3))
    throw std::invalid_argument("the index of refraction of a medium is 1 to 3 times its surroundings'");
}

// Of light inside that meets the boundary.
FresnelMoments insideMoments(double relative_ior) {
  return fresnelMoments(1 / relative_ior);
}

}  // namespace

double fresnelReflectance(double cosine, double relative_ior) {
  if (relative_ior == 1) return 0;
  const double sine2 = (1 - cosine * cosine) / (relative_ior * relative_ior);
  if (sine2 >= 1) return 1;
  const double beyond = std::sqrt(1 - sine2);
  const double parallel = (relative_ior * cosine - beyond) / (relative_ior * cosine + beyond);
  const double perpendicular = (cosine - relative_ior * beyond) / (cosine + relative_ior * beyond);
  return (parallel * parallel + perpendicular * perpendicular) / 2;
}

double schlickTransmittance(double cosine, double relative_ior) {
  const double normal = std::pow((relative_ior - 1) / (relative_ior + 1), 2);
  return (1 - normal) * (1 - std::pow(1 - std::clamp(cosine, 0.0, 1.0), 5));
}

std::vector<double> enteringCosineFactors(int order, double relative_ior) {
  // A polynomial, so this is exact: P_l times the cosine times one of degree 5.
  std::vector<double> factors(static_cast<std::size_t>(order), 0);
  for (const QuadratureNode& node : gaussLegendreRule(order + 4)) {
    const double cosine = (node.x + 1) / 2;
    const double weight = kPi * node.weight * cosine * schlickTransmittance(cosine, relative_ior);
    double legendre = 1, before = 0;
    for (int l = 0; l < order; ++l) {
      factors[static_cast<std::size_t>(l)] += weight * legendre;
      const double next = ((2 * l + 1) * cosine * legendre - l * before) / (l + 1);
      before = legendre, legendre = next;
    }
  }
  return factors;
}

FresnelMoments fresnelMoments(double relative_ior) {
  // Beyond the critical angle all is reflected; before it F has a square root, which μ = critical + x² takes away.
  const double critical = relative_ior < 1 ? std::sqrt(1 - relative_ior * relative_ior) : 0;
  FresnelMoments moments{critical * critical / 2, critical * critical * critical / 3};
  const double end = std::sqrt(1 - critical);
  static const std::vector<QuadratureNode> rule = gaussLegendreRule(128);
  for (const QuadratureNode& node : rule) {
    const double x = end * (node.x + 1) / 2, cosine = critical + x * x;
    const double weight = end / 2 * node.weight * 2 * x * fresnelReflectance(cosine, relative_ior);
    moments.first += weight * cosine;
    moments.second += weight * cosine * cosine;
  }
  return moments;
}

DiffuseReflectance::DiffuseReflectance(DiffusionModel model, const ScatteringCoefficients& c) {
  requireUsable(c);
  const double albedo = c.albedo(), path = 1 / c.extinction();
  const FresnelMoments inside = insideMoments(c.relative_ior);
  // What the boundary sends back, as an offset of the mirrored source (A of both dipoles).
  const double boundary = (1 + 3 * inside.second) / (1 - 2 * inside.first);
  switch (model) {
    case DiffusionModel::kDipole: {
      const double diffuse = 2 * inside.first, offset = (1 + diffuse) / (1 - diffuse);
      const double weight = albedo / (4 * kPi);
      groups_.push_back({std::sqrt(3 * c.absorption * c.extinction()),
                         {{path, weight, 0}, {path * (1 + 4 * offset / 3), weight, 0}}});
      break;
    }
    case DiffusionModel::kBetterDipole: {
      const double diffusion =
          (2 * c.absorption + c.reduced_scattering) / (3 * c.extinction() * c.extinction());
      const double mirrored = path + 4 * boundary * diffusion;
      const double of_fluence = (1 - 2 * inside.first) / 4, of_flux = (1 - 3 * inside.second) / 2;
      const double weight = albedo / (4 * kPi);
      groups_.push_back({std::sqrt(c.absorption / diffusion),
                         {{path, weight * of_flux, weight * of_fluence / diffusion},
                          {mirrored, weight * of_flux, -weight * of_fluence / diffusion}}});
      break;
    }
    case DiffusionModel::kNormalizedDiffusion: {
      // By the total and the mean free path; light that enters from all around (Christensen & Burley 2015, equation 6 of "Approximate
      // Reflectance Profiles for Efficient Subsurface Scattering").
      const double total = DiffuseReflectance(DiffusionModel::kDipole, c).total();
      const double scaling = 1.85 - total + 7 * std::pow(std::abs(total - 0.8), 3);
      const double weight = total * scaling / (8 * kPi * path);
      for (const double attenuation : {scaling / path, scaling / (3 * path)})
        groups_.push_back({attenuation, {{0, 0, weight}}, weight});
      break;
    }
  }
}

double DiffuseReflectance::operator()(double distance) const {
  double sum = 0;
  for (const Group& group : groups_)
    for (const Source& source : group.sources) {
      const double d = std::hypot(distance, source.depth), fallen = std::exp(-group.attenuation * d) / d;
      sum += fallen * (source.fluence + source.flux * source.depth * (group.attenuation + 1 / d) / d);
    }
  return sum;
}

double DiffuseReflectance::enclosed(double radius) const {
  double sum = 0;
  for (const Group& group : groups_)
    for (const Source& source : group.sources) {
      const double d = std::hypot(radius, source.depth);
      // d − z without cancellation
      const double farther = radius * radius / (d + source.depth),
                   at_middle = std::exp(-group.attenuation * source.depth);
      // e^{−σz} − z/d e^{−σd}, whose 1 − z/d is (d − z)/d
      const double left = std::exp(-group.attenuation * farther);
      sum += at_middle *
             (source.flux * ((d > 0 ? farther / d : 0) * left - std::expm1(-group.attenuation * farther)) +
              source.fluence * decayed(group.attenuation, farther));
    }
  return 2 * kPi * sum;
}

double DiffuseReflectance::lineSpread(double distance) const {
  double sum = 0;
  for (const Group& group : groups_)
    for (const Source& source : group.sources) {
      const double rho = std::hypot(distance, source.depth), x = group.attenuation * rho;
      // x K₁(x) is 1 and K₀ a logarithm, of which only differences count, where nothing is absorbed.
      const bool fades = x > 1e-150;
      const double first = !fades ? 1 : x > 700 ? 0 : x * std::cyl_bessel_k(1, x);
      const double zeroth = !fades ? -std::log(rho) : x > 700 ? 0 : std::cyl_bessel_k(0, x);
      sum += 2 * (source.flux * source.depth * first / (rho * rho) + source.fluence * zeroth);
    }
  return sum;
}

double DiffuseReflectance::frequencyResponse(double wavenumber) const {
  double sum = 0;
  for (const Group& group : groups_) {
    const double q = std::hypot(group.attenuation, wavenumber);
    for (const Source& source : group.sources)
      sum += source.flux * std::exp(-q * source.depth) - source.fluence * decayed(q, source.depth);
    if (group.fluence != 0) sum += group.fluence / q;
  }
  return 2 * kPi * sum;
}

double DiffuseReflectance::bandLimited(double distance, double spacing) const {
  const double sides = distance / spacing;
  return BandLimit(std::span(&sides, 1))(*this, spacing).front() / (spacing * spacing);
}

// ∫ R̂(k) W(k) J₀(kr) k dk / 2π, W falling as a raised cosine, whose own transform is nearly nothing at all grid points but 0.
BandLimit::BandLimit(std::span<const double> distances) {
  static const std::vector<QuadratureNode> rule = gaussLegendreRule(96);
  for (const QuadratureNode& node : rule) wavenumbers_.push_back(0.75 * kPi * (node.x + 1));
  for (const double distance : distances)
    for (std::size_t i = 0; i < rule.size(); ++i) {
      const double k = wavenumbers_[i], share = k / kPi;
      const double window = share < 0.5 ? 1 : (1 + std::cos(kPi * (share - 0.5))) / 2;
      weights_.push_back(0.75 * kPi * rule[i].weight * window * std::cyl_bessel_j(0, k * distance) * k /
                         (2 * kPi));
    }
}

std::vector<double> BandLimit::operator()(const DiffuseReflectance& reflectance, double spacing) const {
  std::vector<double> responses, values;
  for (const double k : wavenumbers_) responses.push_back(reflectance.frequencyResponse(k / spacing));
  for (std::size_t first = 0; first < weights_.size(); first += responses.size()) {
    double sum = 0;
    for (std::size_t i = 0; i < responses.size(); ++i) sum += weights_[first + i] * responses[i];
    values.push_back(sum);
  }
  return values;
}

double DiffuseReflectance::radiusFor(double share) const {
  const double all = total(), target = (1 - share) * all;
  double high = 0;
  for (const Group& group : groups_)
    for (const Source& source : group.sources)
      high = std::max({high, source.depth, group.attenuation > 0 ? 1 / group.attenuation : 0.0});
  while (enclosed(high) < target) {
    high *= 2;
    if (high > 1e150) return std::numeric_limits<double>::infinity();
  }
  double low = 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (enclosed(middle) < target ? low : high) = middle;
  }
  return high;
}

ScatteringCoefficients coefficientsOfReflectance(DiffusionModel model, double reflectance, double extinction,
                                                 double relative_ior) {
  if (!(reflectance > 0)) throw std::invalid_argument("a medium that scatters reflects more than nothing");
  // 1 − α′ is q²: the total falls off with q from q = 0 on.
  const auto medium = [&](double q) {
    return ScatteringCoefficients{extinction * (1 - q) * (1 + q), extinction * q * q, relative_ior};
  };
  double low = 0, high = 1;
  if (reflectance >= 1 || DiffuseReflectance(model, medium(0)).total() <= reflectance) return medium(0);
  constexpr int kSteps = 60;
  for (int step = 0; step < kSteps; ++step) {
    const double middle = (low + high) / 2;
    if (middle == 1) break;
    (DiffuseReflectance(model, medium(middle)).total() > reflectance ? low : high) = middle;
  }
  return medium(low);
}

}  // namespace bakelight::transport
