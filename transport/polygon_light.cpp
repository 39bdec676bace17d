#include "transport/polygon_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "formats/error.h"

namespace bakelight::transport {
namespace {

constexpr double kPi = std::numbers::pi;
// Sine of the angle between two opposite corners below which the great circle through them is anyone's guess.
constexpr double kOpposite = 1e-8;
constexpr int kAxisSteps = 100000;

Error badVertex(std::size_t i, const std::string& what) {
  return badInput({"", "polygon vertex " + std::to_string(i), ""}, what,
                  "a polygon that spans less than a hemisphere");
}

std::vector<Vec3> unitDirections(std::span<const Vec3> vertices) {
  std::vector<Vec3> unit;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    unit.push_back(vertices[i].stableNormalized());
    if (!(unit[i].norm() > 0.5)) throw badVertex(i, "it has no direction");
  }
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const Vec3& next = unit[(i + 1) % unit.size()];
    if (unit[i].dot(next) < 0 && unit[i].cross(next).norm() < kOpposite)
      throw badVertex(i, "it and the next one lie in opposite directions");
  }
  return unit;
}

// Of the region to the left of the outline as seen from outside the sphere, in [0, 4π).
double solidAngleOnTheLeft(const std::vector<Vec3>& corners) {
  double total = 0;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const Vec3 &a = corners[0], &b = corners[i - 1], &c = corners[i];
    const double volume = a.dot((b - a).cross(c - a));  // a · (b × c) without its cancellation
    total += 2 * std::atan2(volume, 1 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return total < 0 ? total + 4 * kPi * std::ceil(-total / (4 * kPi)) : std::fmod(total, 4 * kPi);
}

// +1 if the smaller region lies to the left.
double orientation(double solid_angle_on_the_left) {
  return solid_angle_on_the_left <= 2 * kPi ? 1 : -1;
}

// −1/(l(l+1)) ∂y_lm/∂ν along the equator, divided by cos mφ (m ≥ 0) or sin |m|φ (m < 0), for the region to
// the north. The derivative follows from (1−z²) dP_l^m/dz = (l+m) P_{l−1}^m − l z P_l^m.
std::vector<double> equatorFactors(int order) {
  const std::vector<double> equator = evaluateSh(order, Vec3::UnitX());
  std::vector<double> factors(coefficientCount(order), 0.0);
  for (int l = 1; l < order; ++l)
    for (int m = -(l - 1); m < l; ++m)
      factors[coefficientIndex(l, m)] = std::sqrt((2 * l + 1.0) * (l * l - m * m) / (2 * l - 1.0)) *
                                        equator[coefficientIndex(l - 1, std::abs(m))] / (l * (l + 1.0));
  return factors;
}

// The arc's part of the integral along the outline, in the frame where it runs along the equator from +x.
std::vector<double> arcIntegral(int order, double length_rad, const std::vector<double>& factors) {
  std::vector<double> integral(coefficientCount(order), 0.0);
  for (int l = 1; l < order; ++l) {
    integral[coefficientIndex(l, 0)] = factors[coefficientIndex(l, 0)] * length_rad;
    for (int m = 1; m < l; ++m) {
      const double half_sine = std::sin(m * length_rad / 2);
      integral[coefficientIndex(l, m)] = factors[coefficientIndex(l, m)] * std::sin(m * length_rad) / m;
      integral[coefficientIndex(l, -m)] = factors[coefficientIndex(l, -m)] * 2 * half_sine * half_sine / m;
    }
  }
  return integral;
}

// Columns: `from`, a quarter turn on towards `to`, and the arc's pole. False for an arc without length.
bool arcFrame(const Vec3& from, const Vec3& to, Eigen::Matrix3d& world_from_arc) {
  const Vec3 step = to - from;
  Vec3 ahead = step - from * from.dot(step);
  if (!(ahead.norm() > 1e-15)) return false;
  ahead.normalize();
  ahead = (ahead - from * from.dot(ahead)).normalized();  // a short arc leaves rounding along `from`
  world_from_arc << from, ahead, from.cross(ahead);
  return true;
}

// By the perceptron's rule, which ends if there is such a direction with some margin.
bool findAxis(const std::vector<Vec3>& corners, Vec3& axis) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& corner : corners) sum += corner;
  for (int step = 0; step < kAxisSteps; ++step) {
    const auto farthest = std::min_element(corners.begin(), corners.end(), [&](const Vec3& a, const Vec3& b) {
      return a.dot(sum) < b.dot(sum);
    });
    if (farthest->dot(sum) > 1e-9 * sum.norm()) {
      axis = sum.normalized();
      return true;
    }
    sum += *farthest;
  }
  return false;
}

}  // namespace

std::vector<double> polygonSh(int order, std::span<const Vec3> vertices) {
  const std::vector<Vec3> corners = unitDirections(vertices);
  const std::vector<double> factors = equatorFactors(order);
  const double left = solidAngleOnTheLeft(corners), sign = orientation(left);

  std::vector<double> total(coefficientCount(order), 0.0), turned(total.size());
  Eigen::Matrix3d world_from_arc;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 &from = corners[i], &to = corners[(i + 1) % corners.size()];
    if (!arcFrame(from, to, world_from_arc)) continue;
    const double length_rad = std::atan2(from.cross(to).norm(), from.dot(to));
    ShRotation(order, world_from_arc)
        .apply(std::span<const double>(arcIntegral(order, length_rad, factors)), std::span(turned));
    for (std::size_t k = 0; k < total.size(); ++k) total[k] += sign * turned[k];
  }
  total[0] = (sign > 0 ? left : 4 * kPi - left) / std::sqrt(4 * kPi);
  return total;
}

double polygonSolidAngle(std::span<const Vec3> vertices) {
  const double left = solidAngleOnTheLeft(unitDirections(vertices));
  return std::min(left, 4 * kPi - left);
}

PolygonOutline::PolygonOutline(std::span<const Vec3> vertices) {
  const std::vector<Vec3> corners = unitDirections(vertices);
  Vec3 axis = Vec3::UnitZ();
  if (!corners.empty() && !findAxis(corners, axis))
    throw badInput({"", "polygon", ""}, "it spans a hemisphere or more", "corners within a hemisphere",
                   "cut it into several polygons");
  const Vec3 x = axis.unitOrthogonal();
  frame_ = {x, axis.cross(x), axis};
  for (const Vec3& corner : corners) corners_.push_back(projected(corner));
}

Eigen::Vector2d PolygonOutline::projected(const Vec3& direction) const {
  return Eigen::Vector2d(direction.dot(frame_[0]), direction.dot(frame_[1])) / direction.dot(frame_[2]);
}

bool PolygonOutline::contains(const Vec3& direction) const {
  if (!(direction.dot(frame_[2]) > 0)) return false;
  const Eigen::Vector2d point = projected(direction);
  bool inside = false;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Eigen::Vector2d &a = corners_[i], &b = corners_[(i + 1) % corners_.size()];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

}  // namespace bakelight::transport
