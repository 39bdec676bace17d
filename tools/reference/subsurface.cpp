#include "tools/reference/subsurface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/camera.h"
#include "transport/surface_points.h"

namespace bakelight::reference {
namespace {

using transport::Hit;
using transport::vec3;

constexpr double kPi = std::numbers::pi;
constexpr double kAreaShare = 0.5;                                // of samples
constexpr std::array<double, 3> kAxisShares = {0.25, 0.25, 0.5};  // tangents, normal
constexpr int kShares = 1024;
constexpr double kOutside = 1e-3;  // share of R_d that is left to the samples by area

// What is of the medium; vertices are all there.
formats::TriangleMesh partOf(const formats::TriangleMesh& mesh, const std::vector<std::uint8_t>& of_medium) {
  formats::TriangleMesh part;
  part.positions = mesh.positions;
  part.colors = mesh.colors;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    if (of_medium.empty() || of_medium[t] != 0) part.triangles.push_back(mesh.triangles[t]);
  return part;
}

}  // namespace

// The density of what radiusOf draws, exactly: within a share radii are drawn evenly.
double Subsurface::Profile::density(double radius) const {
  const auto above = std::upper_bound(radii.begin(), radii.end(), radius);
  if (above == radii.end() || !(radius > 0)) return 0;
  const double width = *above - *(above - 1);
  return 1 / (static_cast<double>(radii.size() - 1) * width * 2 * kPi * radius);
}

double Subsurface::Profile::radiusOf(double share) const {
  const double place = share * static_cast<double>(radii.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), radii.size() - 2);
  return radii[below] + (place - static_cast<double>(below)) * (radii[below + 1] - radii[below]);
}

Subsurface::Subsurface(const formats::Medium& medium, const formats::TriangleMesh& mesh,
                       std::vector<std::uint8_t> of_medium, const transport::RayScene& rays,
                       const Eigen::Isometry3d& object_from_mesh)
    : mesh_(mesh),
      rays_(rays),
      of_medium_(std::move(of_medium)),
      field_(medium, partOf(mesh, of_medium_), object_from_mesh),
      relative_ior_(medium.eta),
      extent_(2 * transport::boundingSphere(mesh).radius) {
  const auto add = [&](const transport::DiffuseReflectance& reflectance) {
    const double farthest = std::min(extent_, reflectance.radiusFor(kOutside)),
                 enclosed = reflectance.enclosed(farthest);
    std::vector<double> radii = {0};
    for (int share = 1; share < kShares; ++share) {
      double low = radii.back(), high = farthest;
      for (int step = 0; step < 60; ++step) {
        const double middle = (low + high) / 2;
        (reflectance.enclosed(middle) < enclosed * share / kShares ? low : high) = middle;
      }
      radii.push_back(std::max(high, std::nextafter(radii.back(), farthest)));
    }
    radii.push_back(farthest);
    profiles_.push_back({std::move(radii)});
  };
  for (const auto& color : field_.reflectances().front()) add(color);
  if (!field_.isUniform())
    for (const auto& color : field_.reflectances().back()) add(color);
  double area = 0;
  cumulative_area_.push_back(0);
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    if (of_medium_.empty() || of_medium_[t] != 0) {
      const formats::Triangle& corners = mesh.triangles[t];
      const Vec3 a = vec3(mesh.positions[corners[0]]);
      area += (vec3(mesh.positions[corners[1]]) - a).cross(vec3(mesh.positions[corners[2]]) - a).norm() / 2;
    }
    cumulative_area_.push_back(area);
  }
}

Rgb Subsurface::reflectance(const Place& from, const Place& to) const {
  // A distance of rounding is none that normalized diffusion could be asked at.
  const double least = extent_ * 1e-9, distance = std::max((to.position - from.position).norm(), least);
  const transport::MediumField::Place way = field_.isOfSurface()
                                                ? field_.along(from.around, to.around, distance)
                                                : field_.along(from.position, to.position);
  return {field_.reflectance(0, distance, way), field_.reflectance(1, distance, way),
          field_.reflectance(2, distance, way)};
}

Subsurface::Place Subsurface::placeAt(const Vec3& position, const Rgb& color) const {
  Place place{position, {}};
  if (field_.isOfSurface())
    place.around = field_.surroundings(
        position, {static_cast<float>(color[0]), static_cast<float>(color[1]), static_cast<float>(color[2])});
  return place;
}

Subsurface::Place Subsurface::placeOf(const Hit& hit) const {
  const formats::Triangle& corners = mesh_.triangles[hit.triangle];
  const double u = hit.u, v = hit.v;
  const auto between = [&](const std::vector<formats::Float3>& values) -> Vec3 {
    return (1 - u - v) * vec3(values[corners[0]]) + u * vec3(values[corners[1]]) +
           v * vec3(values[corners[2]]);
  };
  return placeAt(between(mesh_.positions),
                 mesh_.colors.empty() ? Rgb(Rgb::Ones()) : Rgb(between(mesh_.colors).array()));
}

Vec3 Subsurface::normalOf(std::uint32_t triangle) const {
  const formats::Triangle& corners = mesh_.triangles[triangle];
  const Vec3 a = vec3(mesh_.positions[corners[0]]);
  return (vec3(mesh_.positions[corners[1]]) - a).cross(vec3(mesh_.positions[corners[2]]) - a).normalized();
}

// By area, of all ways to come by a point together.
double Subsurface::density(const Vec3& from, const Eigen::Matrix3d& axes, const Vec3& to,
                           const Vec3& normal) const {
  double sum = kAreaShare / cumulative_area_.back();
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 along = axes.col(axis), offset = to - from;
    const double radius = (offset - along.dot(offset) * along).norm();
    double drawn = 0;
    for (const Profile& profile : profiles_)
      drawn += profile.density(radius) / static_cast<double>(profiles_.size());
    sum +=
        (1 - kAreaShare) * kAxisShares[static_cast<std::size_t>(axis)] * drawn * std::abs(along.dot(normal));
  }
  return sum;
}

std::optional<Subsurface::Entry> Subsurface::alongLine(const Place& exit, const Eigen::Matrix3d& axes,
                                                       int axis, const Vec3& origin, double pick,
                                                       std::uint64_t& rays) const {
  const Vec3 along = axes.col(axis), start = origin + extent_ * along;
  std::optional<Entry> chosen;
  Rgb chosen_weight = Rgb::Zero();
  double total = 0, from = 0;
  const double step = extent_ * 1e-6;  // a few roundings of a float
  // A line meets a triangle once, so this ends.
  for (std::size_t met = 0; met < mesh_.triangleCount(); ++met) {
    ++rays;
    Hit hit = rays_.nearestHit(start, -along, static_cast<float>(from));
    if (!hit.valid) break;
    from = hit.distance + step;
    if (hit.triangle >= mesh_.triangleCount() || (!of_medium_.empty() && of_medium_[hit.triangle] == 0))
      continue;
    const Place place = placeOf(hit);
    const Rgb weight =
        reflectance(exit, place) / density(exit.position, axes, place.position, normalOf(hit.triangle));
    const double power = weight.sum();
    if (!(power > 0)) continue;  // too far for any number
    total += power;
    // One of all, by its power, without keeping them: of two the second with its share of what is left of the number.
    const double share = power / total;
    if (pick < share) {
      hit.back_face = false;
      chosen = Entry{hit, weight};
      chosen_weight = weight / power;
      pick /= share;
    } else {
      pick = (pick - share) / (1 - share);
    }
  }
  if (chosen) chosen->weight = chosen_weight * total;
  return chosen;
}

std::optional<Subsurface::Entry> Subsurface::sample(const Vec3& position, const Rgb& color,
                                                    const Vec3& normal, double choice,
                                                    const std::array<double, 2>& point, double pick,
                                                    std::uint64_t& rays) const {
  const Place exit = placeAt(position, color);
  Eigen::Matrix3d axes;
  axes.col(0) = normal.unitOrthogonal();
  axes.col(1) = normal.cross(axes.col(0));
  axes.col(2) = normal;
  if (choice < kAreaShare) {
    const double target = choice / kAreaShare * cumulative_area_.back();
    const auto above = std::upper_bound(cumulative_area_.begin() + 1, cumulative_area_.end() - 1, target);
    Hit hit;
    hit.valid = true;
    hit.triangle = static_cast<std::uint32_t>(above - cumulative_area_.begin() - 1);
    const double root = std::sqrt(point[0]);
    hit.u = static_cast<float>(root * (1 - point[1]));
    hit.v = static_cast<float>(root * point[1]);
    const Place place = placeOf(hit);
    return Entry{hit,
                 reflectance(exit, place) / density(position, axes, place.position, normalOf(hit.triangle))};
  }
  choice = (choice - kAreaShare) / (1 - kAreaShare);
  int axis = 0;
  while (axis < 2 && choice >= kAxisShares[static_cast<std::size_t>(axis)])
    choice -= kAxisShares[static_cast<std::size_t>(axis++)];
  const auto drawn = std::min(static_cast<std::size_t>(static_cast<double>(profiles_.size()) * choice /
                                                       kAxisShares[static_cast<std::size_t>(axis)]),
                              profiles_.size() - 1);
  const double radius = profiles_[drawn].radiusOf(point[0]), turn = 2 * kPi * point[1];
  const Vec3 across = axes.col((axis + 1) % 3), up = axes.col((axis + 2) % 3);
  return alongLine(exit, axes, axis, position + radius * (std::cos(turn) * across + std::sin(turn) * up),
                   pick, rays);
}

}  // namespace bakelight::reference
