#include "tools/rtt/light_directions.h"

#include <cmath>
#include <numbers>

#include "transport/gauss_legendre.h"
#include "transport/sh.h"

namespace bakelight::rtt {
namespace {

using std::numbers::pi;

// Heights from the top down; weights are of ∫ dz from 0 to 1.
std::vector<transport::QuadratureNode> heights(LightRule rule, int count) {
  std::vector<transport::QuadratureNode> nodes;
  if (rule == LightRule::kGaussLegendre) {
    for (const auto& node : transport::gaussLegendreRule(count))
      nodes.push_back({(1 + node.x) / 2, node.weight / 2});
    return nodes;
  }
  const double step = pi / 2 / count;
  for (int i = 0; i < count; ++i) {
    const double angle = (i + 0.5) * step;
    nodes.push_back({std::cos(angle), std::sin(angle) * step});
  }
  return nodes;
}

}  // namespace

std::vector<LightDirection> lightDirections(LightRule rule, int polar, int azimuths, int order) {
  std::vector<LightDirection> lights;
  for (const auto& [z, weight] : heights(rule, polar))
    for (int j = 0; j < azimuths; ++j) {
      const double azimuth = 2 * pi * (j + 0.5) / azimuths, across = std::sqrt(1 - z * z);
      const Vec3 towards(across * std::cos(azimuth), across * std::sin(azimuth), z);
      lights.push_back({towards, weight * 2 * pi / azimuths, transport::evaluateSh(order, towards)});
    }
  return lights;
}

}  // namespace bakelight::rtt
