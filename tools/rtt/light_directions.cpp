#include "tools/rtt/light_directions.h"

#include <cmath>
#include <numbers>

#include "tools/rtt/light_basis.h"
#include "transport/gauss_legendre.h"
#include "transport/hemisphere_grid.h"
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
      lights.push_back({towards, weight * 2 * pi / azimuths, 0, transport::evaluateSh(order, towards)});
    }
  return lights;
}

std::vector<LightDirection> cellLights(int side, int samples) {
  const std::vector<transport::QuadratureNode> nodes = transport::gaussLegendreRule(samples);
  const double cell_sr = cellSolidAngle(side);
  const auto at = [side](int cell, double node) { return (cell + (1 + node) / 2) / side; };
  std::vector<LightDirection> lights;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const auto cell = static_cast<std::size_t>(row) * side + column;
      for (const auto& up : nodes)
        for (const auto& across : nodes)
          lights.push_back({transport::hemisphereFromSquare(at(column, across.x), at(row, up.x)),
                            cell_sr * across.weight * up.weight / 4,
                            cell,
                            {1 / cell_sr}});
    }
  return lights;
}

}  // namespace bakelight::rtt
