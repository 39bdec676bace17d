#include "tools/brdf/brdf.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <variant>

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

Brdf ggx(const transport::Microfacets& facets) {
  if (facets.isMirror()) throw std::invalid_argument("ggx: a mirror has no BRDF");
  return [facets](const Vec3& incident, const Vec3& outgoing) { return facets.brdf(incident, outgoing); };
}

Brdf reflection(const formats::Reflection& reflection) {
  if (const auto* phong = std::get_if<formats::PhongReflection>(&reflection)) {
    const Vec3 color = transport::vec3(phong->specular_color);
    return [color, exponent = phong->exponent](const Vec3& incident, const Vec3& outgoing) -> Vec3 {
      const Vec3 mirrored(-outgoing.x(), -outgoing.y(), outgoing.z());
      const double cosine = std::clamp(mirrored.dot(incident), 0.0, 1.0);
      const double lobe = (exponent + 1) / (2 * kPi) * std::pow(cosine, exponent);
      return color * (lobe / std::max(incident.z(), 1e-300));
    };
  }
  if (const auto* microfacets = std::get_if<formats::GgxReflection>(&reflection))
    return ggx(transport::Microfacets(transport::vec3(microfacets->specular_color),
                                      std::max(microfacets->roughness, kSmallestRoughness),
                                      microfacets->fresnel, microfacets->multiple_scattering));
  if (std::holds_alternative<formats::TableReflection>(reflection))
    throw std::invalid_argument("brdf::reflection: a table is a projection");
  return [](const Vec3&, const Vec3&) -> Vec3 { return Vec3::Zero(); };
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

formats::TensorFile tensorFile(const std::map<std::string, formats::BrdfTable>& tables) {
  formats::TensorFile file;
  for (const auto& [material, table] : tables) {
    const auto count = static_cast<std::uint64_t>(transport::coefficientCount(table.order));
    file.tensors[formats::brdfTensorOf(material)] = formats::Tensor::from<float>(
        formats::ElementType::kFloat32, {static_cast<std::uint64_t>(table.angles), 3, count}, table.values);
  }
  file.metadata = {{"order", std::to_string(tables.begin()->second.order)},
                   {"basis", "real_sh_cartesian"},
                   {"frame", "local"},
                   {"cosine", "inside"},
                   {"angles", "cos theta of the eye from 0 to 1 in equal steps, azimuth 0"}};
  return file;
}

}  // namespace bakelight::brdf
