#include "tools/brdf/brdf.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "transport/gauss_legendre.h"
#include "transport/sh.h"

namespace bakelight::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kFewestNodes = 8, kMostNodes = 32;  // of a panel
constexpr double kSmallestPanel_rad = 1e-3;

struct Node {
  double angle_rad, weight;
};

// Nodes over begin … end, in panels that double in width away from `peak`.
std::vector<Node> gradedNodes(double begin, double end, double peak, int nodes_a_panel) {
  std::vector<double> edges = {begin, end, peak};
  for (double distance = kSmallestPanel_rad; distance < end - begin; distance *= 2)
    for (const double edge : {peak - distance, peak + distance})
      if (edge > begin && edge < end) edges.push_back(edge);
  std::ranges::sort(edges);

  const std::vector<transport::QuadratureNode> rule = transport::gaussLegendreRule(nodes_a_panel);
  std::vector<Node> nodes;
  for (std::size_t panel = 0; panel + 1 < edges.size(); ++panel) {
    const double half = (edges[panel + 1] - edges[panel]) / 2, middle = (edges[panel + 1] + edges[panel]) / 2;
    if (half <= 0) continue;
    for (const auto& [x, weight] : rule) nodes.push_back({middle + half * x, half * weight});
  }
  return nodes;
}

struct Row {
  std::vector<double> coefficients;  // RGB × order²
  Vec3 albedo = Vec3::Zero();
};

// Over half the hemisphere: isotropy doubles what is even in azimuth, m ≥ 0, and takes away the rest.
Row projectRow(const Brdf& brdf, int order, double eye_angle_rad, int nodes_a_panel) {
  const std::size_t count = transport::coefficientCount(order);
  Row row{std::vector<double>(3 * count, 0.0)};
  const Vec3 eye(std::sin(eye_angle_rad), 0, std::cos(eye_angle_rad));
  const std::vector<Node> azimuths = gradedNodes(0, kPi, kPi, nodes_a_panel);
  std::vector<double> y(count);
  for (const Node& polar : gradedNodes(0, kPi / 2, eye_angle_rad, nodes_a_panel)) {
    const double sine = std::sin(polar.angle_rad), cosine = std::cos(polar.angle_rad);
    for (const Node& azimuth : azimuths) {
      const Vec3 light(sine * std::cos(azimuth.angle_rad), sine * std::sin(azimuth.angle_rad), cosine);
      const Vec3 value = 2 * polar.weight * azimuth.weight * sine * cosine * brdf(light, eye);
      row.albedo += value;
      transport::evaluateSh(order, light, y);
      for (int l = 0; l < order; ++l)
        for (int m = 0; m <= l; ++m) {
          const int i = transport::coefficientIndex(l, m);
          for (std::size_t c = 0; c < 3; ++c) row.coefficients[c * count + i] += value[c] * y[i];
        }
    }
  }
  return row;
}

double largest(const std::vector<double>& values) {
  double maximum = 0;
  for (const double value : values) maximum = std::max(maximum, std::abs(value));
  return maximum;
}

double largestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> difference(a.size());
  std::ranges::transform(a, b, difference.begin(), std::minus<>());
  return largest(difference);
}

}  // namespace

Brdf lambert(const Vec3& diffuse_color) {
  const Vec3 value = diffuse_color / kPi;
  return [value](const Vec3&, const Vec3&) { return value; };
}

Brdf phong(const Vec3& diffuse_color, const Vec3& specular_color, double exponent) {
  const Vec3 diffuse = diffuse_color / kPi, specular = specular_color * (exponent + 2) / (2 * kPi);
  return [=](const Vec3& incident, const Vec3& outgoing) -> Vec3 {
    const Vec3 mirrored(-incident.x(), -incident.y(), incident.z());
    const double cosine = std::clamp(mirrored.dot(outgoing), 0.0, 1.0);
    return diffuse + specular * std::pow(cosine, exponent);
  };
}

Brdf ggx(const Vec3& diffuse_color, const Vec3& specular_color, double roughness) {
  if (!(roughness > 0)) throw std::invalid_argument("ggx: a mirror has no BRDF");
  const Vec3 diffuse = diffuse_color / kPi;
  const double alpha2 = std::pow(roughness, 4);
  return [=](const Vec3& incident, const Vec3& outgoing) -> Vec3 {
    const Vec3 half = (incident + outgoing).normalized();
    // 1 − (1 − α²) cos² of the half angle; the sine is exact near the peak, where the difference is not.
    const double sine2 = half.x() * half.x() + half.y() * half.y();
    const double fall = sine2 + alpha2 * half.z() * half.z();
    const double distribution = alpha2 / (kPi * fall * fall);
    const double in = std::max(incident.z(), 0.0), out = std::max(outgoing.z(), 0.0);
    // Shadowing over 4 cos cos, finite at grazing angles but where both graze.
    const double smith =
        out * std::sqrt(alpha2 + (1 - alpha2) * in * in) + in * std::sqrt(alpha2 + (1 - alpha2) * out * out);
    const double grazing = std::pow(1 - std::clamp(half.dot(incident), 0.0, 1.0), 5);
    const Vec3 fresnel = specular_color + (Vec3::Ones() - specular_color) * grazing;
    return diffuse + fresnel * (distribution * 0.5 / std::max(smith, 1e-300));
  };
}

Projection project(const Brdf& brdf, int order, int angles, double tolerance) {
  if (angles < 2) throw std::invalid_argument("brdf::project: fewer than two angles");
  const std::size_t width = 3 * transport::coefficientCount(order);
  Projection projection;
  projection.table.angles = angles;
  projection.table.order = order;
  projection.table.values.resize(angles * width);
  projection.albedo.resize(angles);
  std::vector<double> residuals(angles);
  tbb::parallel_for(0, angles, [&](int angle) {
    const double eye_angle = std::acos(static_cast<double>(angle) / (angles - 1));
    Row row = projectRow(brdf, order, eye_angle, kFewestNodes);
    for (int nodes = 2 * kFewestNodes; nodes <= kMostNodes; nodes *= 2) {
      Row finer = projectRow(brdf, order, eye_angle, nodes);
      const double scale = largest(finer.coefficients);
      residuals[angle] = scale > 0 ? largestDifference(row.coefficients, finer.coefficients) / scale : 0;
      row = std::move(finer);
      if (residuals[angle] <= tolerance) break;
    }
    std::ranges::transform(row.coefficients, &projection.table.values[angle * width],
                           [](double value) { return static_cast<float>(value); });
    projection.albedo[angle] = row.albedo;
  });
  for (const float value : projection.table.values)
    if (!std::isfinite(value)) throw std::invalid_argument("brdf::project: the BRDF is not finite");
  projection.residual = *std::ranges::max_element(residuals);
  return projection;
}

formats::TensorFile tensorFile(const formats::BrdfTable& table) {
  formats::TensorFile file;
  const auto count = static_cast<std::uint64_t>(transport::coefficientCount(table.order));
  file.tensors["brdf"] = formats::Tensor::from<float>(
      formats::ElementType::kFloat32, {static_cast<std::uint64_t>(table.angles), 3, count}, table.values);
  file.metadata = {{"order", std::to_string(table.order)},
                   {"basis", "real_sh_cartesian"},
                   {"frame", "local"},
                   {"cosine", "inside"},
                   {"angles", "cos theta of the eye from 0 to 1 in equal steps, azimuth 0"}};
  return file;
}

}  // namespace bakelight::brdf
