#include "transport/texel_irradiance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "formats/error.h"
#include "transport/diffusion.h"
#include "transport/surface_points.h"

namespace bakelight::transport {
namespace {

using Corners = std::array<std::uint32_t, 3>;

// The same triangle, its least corner first; the first corner moves by so many.
std::pair<Corners, std::size_t> leastFirst(const Corners& corners) {
  const auto first =
      static_cast<std::size_t>(std::min_element(corners.begin(), corners.end()) - corners.begin());
  return {{corners[first], corners[(first + 1) % 3], corners[(first + 2) % 3]}, first};
}

// At a place of a texel: what enters, and what would fall on it if it faced the light.
struct Light {
  Eigen::Array3d entering = Eigen::Array3d::Zero(), facing = Eigen::Array3d::Zero();
};

// Across and down from the middle of a texel, in texels.
using Place = std::array<double, 2>;
constexpr double kCorner = 0.499;  // within the texel, where an edge of light runs along its side
constexpr std::array<Place, 4> kCorners = {Place{-kCorner, -kCorner}, Place{kCorner, -kCorner},
                                           Place{-kCorner, kCorner}, Place{kCorner, kCorner}};

// Hammersley's points: no two in one row or column, so that edges along either count in steps of one place.
std::array<Place, TexelIrradiance::kPlaces> evenPlaces() {
  constexpr auto kCount = static_cast<double>(TexelIrradiance::kPlaces);
  std::array<Place, TexelIrradiance::kPlaces> places{};
  for (std::size_t i = 0; i < places.size(); ++i) {
    double inverse = 0.5 / kCount, half = 0.5;
    for (std::size_t bits = i; bits > 0; bits /= 2, half /= 2) inverse += bits % 2 == 1 ? half : 0;
    places[i] = {(static_cast<double>(i) + 0.5) / kCount - 0.5, inverse - 0.5};
  }
  return places;
}

}  // namespace

TexelIrradiance::TexelIrradiance(const formats::Translucency& translucency, const formats::TriangleMesh& mesh)
    : mesh_(mesh),
      eta_(static_cast<double>(translucency.eta)),
      offset_(static_cast<double>(surfaceOffset(mesh, kDefaultBias))) {
  std::map<Corners, std::pair<std::uint32_t, std::size_t>> triangle_of;  // by knots
  std::map<std::array<std::uint32_t, 2>, std::pair<std::uint32_t, std::uint32_t>>
      edges;  // by knots: triangle, corner
  triangles_.resize(mesh.triangleCount());
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    Corners knots{};
    for (std::size_t k = 0; k < 3; ++k) knots[k] = translucency.knots.at(mesh.triangles[t][k]);
    const auto [corners, first] = leastFirst(knots);
    triangle_of.try_emplace(corners, static_cast<std::uint32_t>(t), first);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = knots[(k + 1) % 3], to = knots[(k + 2) % 3];
      edges.try_emplace({from, to}, static_cast<std::uint32_t>(t), k);
      const auto other =
          edges.find({to, from});  // the other way round, as neighbours of one orientation have it
      if (other == edges.end()) continue;
      const auto [neighbour, corner] = other->second;
      triangles_[t].neighbours[k] = {neighbour, corner};
      triangles_[neighbour].neighbours[corner] = {static_cast<std::uint32_t>(t), k};
    }

    std::array<double, 4> sides{};  // of texture coordinates in texels, rows from the top
    for (std::size_t k = 0; k < 2; ++k) {
      const formats::Float2 &from = mesh.texcoords[mesh.triangles[t][0]],
                            &to = mesh.texcoords[mesh.triangles[t][k + 1]];
      sides[2 * k] = translucency.resolution * static_cast<double>(to[0] - from[0]);
      sides[2 * k + 1] = -translucency.resolution * static_cast<double>(to[1] - from[1]);
    }
    const double det = sides[0] * sides[3] - sides[1] * sides[2];
    if (det == 0) continue;
    triangles_[t].across = {sides[3] / det, -sides[1] / det};
    triangles_[t].down = {-sides[2] / det, sides[0] / det};
  }
  const auto knots = formats::wordsOf(translucency.texel_knots);
  const std::vector<float> weights = translucency.texel_weights.decode();
  auto found = triangle_of.end();  // texels of a triangle follow each other
  for (std::size_t i = 0; i < translucency.texelCount(); ++i) {
    const auto [corners, first] = leastFirst({knots[3 * i], knots[3 * i + 1], knots[3 * i + 2]});
    if (found == triangle_of.end() || found->first != corners) found = triangle_of.find(corners);
    if (found == triangle_of.end())
      throw std::invalid_argument("texel " + std::to_string(i) + " lies in no triangle of the mesh");
    const auto& [triangle, first_of_triangle] = found->second;
    const std::array<float, 3> of_knots = {1 - weights[2 * i] - weights[2 * i + 1], weights[2 * i],
                                           weights[2 * i + 1]};
    // Corner k of the triangle is the texel's knot k + first − first_of_triangle.
    const std::size_t turn = first + 3 - first_of_triangle;
    texels_.push_back({triangle, of_knots[(1 + turn) % 3], of_knots[(2 + turn) % 3]});
  }
}

void TexelIrradiance::walk(std::uint32_t& triangle, double& u, double& v) const {
  constexpr int kMostSteps =
      4;  // half a texel goes no farther in triangles of some size; what is left is clamped
  for (int step = 0; step < kMostSteps; ++step) {
    const std::array<double, 3> weights = {1 - u - v, u, v};
    const auto k =
        static_cast<std::size_t>(std::min_element(weights.begin(), weights.end()) - weights.begin());
    if (weights[k] >= 0) return;
    const Neighbour next = triangles_[triangle].neighbours[k];
    if (next.triangle == kNone) return;
    const auto at = [&](std::uint32_t of, std::size_t corner) {
      return vec3(mesh_.positions[mesh_.triangles[of][corner % 3]]);
    };
    const Vec3 from = at(triangle, k + 1), along = at(triangle, k + 2) - from;
    const double squared_length = along.squaredNorm();
    // A corner by its distance from the edge, and how far along it is, in lengths of the edge.
    const auto placed = [&](const Vec3& corner) {
      const Vec3 way = corner - from;
      const double share = way.dot(along) / squared_length;
      return std::pair((way - share * along).norm(), share);
    };
    const auto [height, share] = placed(at(triangle, k));
    const auto [next_height, next_share] = placed(at(next.triangle, next.corner));
    if (!(squared_length > 0) || !(next_height > 0)) return;
    const double beyond = -weights[k] * height / next_height,
                 there = weights[(k + 2) % 3] + weights[k] * share - beyond * next_share;
    std::array<double, 3> moved{};
    moved[next.corner] = beyond;
    moved[(next.corner + 1) % 3] = there;  // edges run the other way
    moved[(next.corner + 2) % 3] = 1 - beyond - there;
    triangle = next.triangle, u = moved[1], v = moved[2];
  }
}

std::vector<Float3> TexelIrradiance::entering(std::span<const PlacedPunctualLight> lights,
                                              const Occlusion& occluded) const {
  std::vector<Float3> result(texels_.size(), Float3{0, 0, 0});
  const auto at = [&](const Texel& texel, const PlacedPunctualLight& light, const Place& place) -> Light {
    const Surroundings& steps = triangles_[texel.triangle];
    const auto [across, down] = place;
    std::uint32_t triangle = texel.triangle;
    double u = static_cast<double>(texel.u) + across * steps.across[0] + down * steps.down[0],
           v = static_cast<double>(texel.v) + across * steps.across[1] + down * steps.down[1];
    walk(triangle, u, v);
    const SmoothPoint point = smoothPoint(mesh_, triangle, u, v);
    const Vec3 origin = point.lifted + offset_ * point.normal, way = light.position - origin;
    const double distance = way.norm();
    const Vec3 direction = way / distance;
    const double cosine = point.normal.dot(direction);
    const Eigen::Array3d facing = light.irradianceFacing(origin);
    if (!(cosine > 0)) return {Eigen::Array3d::Zero(), facing};  // its shadow is no edge
    if ((facing == 0).all() || occluded(origin, direction, distance)) return {};
    return {facing * (cosine * schlickTransmittance(cosine, eta_)), facing};
  };
  const std::array<Place, kPlaces> places = evenPlaces();
  tbb::parallel_for(std::size_t{0}, texels_.size(), [&](std::size_t t) {
    Eigen::Array3d sum = Eigen::Array3d::Zero();
    for (const PlacedPunctualLight& light : lights) {
      Eigen::Array3d of_corners = Eigen::Array3d::Zero(), of_places = Eigen::Array3d::Zero(),
                     least = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity()),
                     most = Eigen::Array3d::Zero();
      for (const Place& place : kCorners) {
        const Light here = at(texels_[t], light, place);
        of_corners += here.entering;
        least = least.min(here.facing), most = most.max(here.facing);
      }
      if ((most - least <= 0.1 * most).all()) {
        sum += of_corners / static_cast<double>(kCorners.size());
        continue;
      }
      for (const Place& place : places) of_places += at(texels_[t], light, place).entering;
      sum += of_places / static_cast<double>(kPlaces);
    }
    result[t] = float3(sum.matrix());
  });
  for (const Float3& texel : result)
    for (const float value : texel)
      if (!std::isfinite(value))
        throw badInput({"", "punctual lights", ""}, "what they send is not finite",
                       "light that a float can hold, from somewhere off the surface");
  return result;
}

}  // namespace bakelight::transport
