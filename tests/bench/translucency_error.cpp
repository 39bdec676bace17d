#include "tests/bench/translucency_error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "transport/translucent_response.h"

namespace bakelight::bench {
namespace {

using kernels::Rgb;
constexpr int kReach = formats::kKernelSide / 2;

// What the paper's two discretisations say, each on its own.
struct Naive {
  const kernels::Knots& knots;
  const kernels::Texels& texels;
  const kernels::Reflectance& reflectance;
  const std::vector<float>& light;
  std::vector<float> irradiance;  // of knots

  void distribute() {
    irradiance.assign(knots.count(), 0);
    std::vector<double> ones(knots.count(), 0), sums(knots.count(), 0);
    for (std::size_t i = 0; i < texels.count(); ++i)
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t knot = knots.triangles[texels.triangles[i]][static_cast<std::size_t>(k)];
        const double dual = (4 * static_cast<double>(texels.weights[i][k]) - 1) *
                            static_cast<double>(texels.areas[i]) / knots.areas[knot];
        ones[knot] += dual, sums[knot] += dual * static_cast<double>(light[i]);
      }
    for (std::size_t k = 0; k < knots.count(); ++k)
      irradiance[k] = ones[k] > 0 ? static_cast<float>(sums[k] / ones[k]) : 0;
  }
  Rgb atKnot(std::size_t j) const {
    Rgb sum = Rgb::Zero();
    for (std::size_t i = 0; i < knots.count(); ++i)
      if (i != j && irradiance[i] != 0)
        sum += irradiance[i] * static_cast<float>(knots.areas[i]) *
               reflectance.exact(static_cast<float>((knots.positions[i] - knots.positions[j]).norm()),
                                 reflectance.along(knots.point(i), knots.point(j)));
    return sum;
  }
  Rgb local(std::size_t receiver) const {
    Rgb sum = Rgb::Zero();
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const std::int32_t s = texels.neighbour(receiver, dx, dy);
        if (s < 0) continue;
        const auto source = static_cast<std::size_t>(s);
        const float distance = (texels.positions[source] - texels.positions[receiver]).norm();
        sum += light[source] * texels.cells[source] *
               reflectance.betweenTexels(distance, texels.sides[receiver],
                                         reflectance.bandOf(texels.sides[receiver]),
                                         reflectance.along(texels.point(source), texels.point(receiver)));
      }
    return sum;
  }
};

}  // namespace

TranslucencyErrors translucencyErrors(const kernels::Knots& knots, const kernels::Texels& texels,
                                      const kernels::Reflectance& reflectance,
                                      const formats::Translucency& translucency, const LightOnSurface& light,
                                      std::size_t receivers) {
  std::vector<float> entering(texels.count());
  std::vector<formats::Float3> white(texels.count());
  for (std::size_t i = 0; i < texels.count(); ++i) {
    entering[i] = light(texels.positions[i], texels.normals[i]);
    white[i] = {entering[i], entering[i], entering[i]};
  }
  const transport::TranslucentResponse response(translucency);
  using Branches = transport::TranslucentResponse::Branches;
  const auto both = response.respond(white), local = response.respond(white, Branches::kLocal),
             global = response.respond(white, Branches::kGlobal);
  Naive naive{knots, texels, reflectance, entering, {}};
  naive.distribute();

  const auto all = formats::wordsOf(translucency.receivers);
  std::vector<std::size_t> chosen;
  const std::size_t step = std::max<std::size_t>(all.size() / receivers, 1);
  for (std::size_t r = step / 2; r < all.size(); r += step)
    if (texels.areas[all[r]] > 0) chosen.push_back(r);
  std::vector<std::array<double, 7>> sums(chosen.size());
  tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t i) {
    const std::size_t r = chosen[i], texel = all[r];
    const std::uint32_t band = reflectance.bandOf(texels.sides[texel]);
    Eigen::Array3d truth = Eigen::Array3d::Zero();
    for (std::size_t s = 0; s < texels.count(); ++s) {
      const float power = texels.areas[s] * entering[s];
      if (power == 0) continue;
      const float distance = (texels.positions[s] - texels.positions[texel]).norm();
      truth += (power * reflectance.betweenTexels(distance, texels.sides[texel], band,
                                                  reflectance.along(texels.point(s), texels.point(texel))))
                   .cast<double>();
    }
    Rgb apart = naive.local(texel);
    for (int k = 0; k < 3; ++k)
      apart += texels.weights[texel][k] *
               naive.atKnot(knots.triangles[texels.triangles[texel]][static_cast<std::size_t>(k)]);
    const auto squared = [&](const Rgb& value) { return (value.cast<double>() - truth).square().sum(); };
    const auto rgb = [](const formats::Float3& f) { return Rgb(f[0], f[1], f[2]); };
    sums[i] = {squared(rgb(both[r])),
               squared(rgb(local[r])),
               squared(rgb(global[r])),
               squared(apart),
               truth.square().sum(),
               static_cast<double>(rgb(both[r]).sum()),
               truth.sum()};
  });
  std::array<double, 7> sum{};
  for (const auto& each : sums)
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += each[k];
  const auto relative = [&](std::size_t k) { return std::sqrt(sum[k] / sum[4]); };
  return {relative(0), relative(1), relative(2), relative(3), sum[5] / sum[6] - 1};
}

std::vector<std::pair<std::string, LightOnSurface>> testLights(const kernels::Knots& knots) {
  Eigen::Vector3d low = knots.positions.front(), high = low;
  for (const auto& p : knots.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Eigen::Vector3f middle = ((low + high) / 2).cast<float>();
  const auto size = static_cast<float>((high - low).norm());
  const Eigen::Vector3f towards = Eigen::Vector3f(1, 0.6F, 0.3F).normalized();
  const Eigen::Vector3f right = towards.unitOrthogonal(), up = towards.cross(right);
  return {
      {"smooth", [=](const Eigen::Vector3f&, const Eigen::Vector3f& n) { return (1 + n.dot(towards)) / 2; }},
      {"spot",
       [=](const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
         const Eigen::Vector3f d = p - middle;
         return std::hypot(d.dot(right), d.dot(up)) < 0.1F * size ? std::max(n.dot(towards), 0.0F) : 0.0F;
       }},
      {"checkerboard", [=](const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
         const Eigen::Vector3f d = (p - middle) / (0.04F * size);
         const int square =
             static_cast<int>(std::floor(d.dot(right))) + static_cast<int>(std::floor(d.dot(up)));
         return square % 2 == 0 ? std::max(n.dot(towards), 0.0F) : 0.0F;
       }}};
}

}  // namespace bakelight::bench
