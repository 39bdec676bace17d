#include "tools/reference/random_walk.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "transport/diffusion.h"
#include "transport/random.h"
#include "transport/vector_types.h"

namespace bakelight::reference {
namespace {

using transport::Hit;
using transport::vec3;

constexpr double kRouletteBelow = 0.25;  // of the weight that a walk begins with
// Of the farthest coordinate: many roundings in single precision, so that a ray that grazes a triangle it begins at begins before it, too;
// and in double precision.
constexpr double kSlack = 3e-5, kRounding = 1e-12;
constexpr double kStep = 0.5;  // of a cell, along which a flight's coefficients are constant

// SplitMix64.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : state_(seed) {}
  // In [0, 1).
  double next() {
    const std::uint64_t bits = transport::scrambled(state_);
    state_ += 0x9e3779b97f4a7c15U;
    return static_cast<double>(bits >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

Vec3 uniformDirection(RandomNumbers& random) {
  const double z = 1 - 2 * random.next(), turn = 2 * std::numbers::pi * random.next();
  const double radius = std::sqrt(std::max(0.0, 1 - z * z));
  return {radius * std::cos(turn), radius * std::sin(turn), z};
}

// By its share of the weight.
Eigen::Index drawnColor(const Rgb& weight, double number) {
  const double target = number * weight.sum();
  if (target < weight[0]) return 0;
  return target < weight[0] + weight[1] ? 1 : 2;
}

// What is left of each color's light at these depths, against what is left of the one that is left most of, so that no way is too long.
Rgb attenuated(const Rgb& depths) {
  return (depths.minCoeff() - depths).exp();
}

}  // namespace

RandomWalk::RandomWalk(const formats::Medium& medium, const formats::TriangleMesh& mesh,
                       std::vector<std::uint8_t> of_medium, const transport::RayScene& rays,
                       const Eigen::Isometry3d& object_from_mesh)
    : mesh_(mesh),
      rays_(rays),
      of_medium_(std::move(of_medium)),
      field_(medium, mesh.positions, object_from_mesh),
      relative_ior_(medium.eta),
      diffuse_transmittance_(1 - 2 * transport::fresnelMoments(medium.eta).first),
      lowest_(Vec3::Constant(std::numeric_limits<double>::infinity())),
      highest_(-lowest_) {
  for (const formats::Float3& position : mesh.positions) {
    lowest_ = lowest_.cwiseMin(vec3(position));
    highest_ = highest_.cwiseMax(vec3(position));
  }
  slack_ = kSlack * std::max(lowest_.cwiseAbs().maxCoeff(), highest_.cwiseAbs().maxCoeff());
}

Rgb RandomWalk::extinctionAt(const Vec3& position) const {
  const double share = field_.shareAt(position);
  return {field_.coefficients(0, share).extinction(), field_.coefficients(1, share).extinction(),
          field_.coefficients(2, share).extinction()};
}

Rgb RandomWalk::scatteringAt(const Vec3& position) const {
  const double share = field_.shareAt(position);
  return {field_.coefficients(0, share).reduced_scattering, field_.coefficients(1, share).reduced_scattering,
          field_.coefficients(2, share).reduced_scattering};
}

double RandomWalk::lengthOf(const Segment& segment, Eigen::Index color, double depth) const {
  if (field_.isUniform()) return depth / extinctionAt(segment.origin)[color];
  const double step = kStep * field_.cell();
  // Beyond the mesh nothing is left to meet.
  const double farthest = (highest_ - lowest_).norm() + step;
  for (double length = 0; length < farthest; length += step) {
    const double extinction = extinctionAt(segment.origin + (length + step / 2) * segment.direction)[color];
    if (depth < extinction * step) return length + depth / extinction;
    depth -= extinction * step;
  }
  return farthest;
}

// Of the step in which it ends: what it has met there, it scatters by, too.
Vec3 RandomWalk::lastMiddle(const Segment& segment, double length) const {
  const double step = kStep * field_.cell();
  return segment.origin + (std::floor(length / step) + 0.5) * step * segment.direction;
}

Rgb RandomWalk::depthOf(const Segment& segment, double length) const {
  if (field_.isUniform()) return extinctionAt(segment.origin) * length;
  const double step = kStep * field_.cell();
  Rgb depths = Rgb::Zero();
  for (double from = 0; from < length; from += step)
    depths +=
        extinctionAt(segment.origin + (from + step / 2) * segment.direction) * std::min(step, length - from);
  return depths;
}

Vec3 RandomWalk::cornerOf(std::uint32_t triangle, std::size_t corner) const {
  return vec3(mesh_.positions[mesh_.triangles[triangle][corner]]);
}

Vec3 RandomWalk::crossOf(std::uint32_t triangle) const {
  const Vec3 a = cornerOf(triangle, 0);
  return (cornerOf(triangle, 1) - a).cross(cornerOf(triangle, 2) - a);
}

bool RandomWalk::withinBounds(const Vec3& position) const {
  return (position.array() >= lowest_.array() - slack_).all() &&
         (position.array() <= highest_.array() + slack_).all();
}

Vec3 RandomWalk::refracted(const Start& start, const Vec3& towards_eye) const {
  const auto below = [&](const Vec3& normal) -> Vec3 {
    const double along = normal.dot(towards_eye), cosine = std::abs(along);
    const Vec3 above = towards_eye + (cosine - along) * normal;
    const double inside = std::sqrt(1 - (1 - cosine * cosine) / (relative_ior_ * relative_ior_));
    return ((cosine / relative_ior_ - inside) * normal - above / relative_ior_).normalized();
  };
  const Vec3 direction = below(start.normal);
  if (start.triangle == kNoTriangle) return direction;
  const Vec3 face = (start.back_face ? -1 : 1) * crossOf(start.triangle).normalized();
  return direction.dot(face) < 0 ? direction : below(face);
}

// Single precision finds triangles, from a little behind the segment so that none is missed; double precision says where they are, so that free paths much
// shorter than a rounding of the coordinates come out right too.
std::optional<RandomWalk::Boundary> RandomWalk::boundaryOn(const Segment& segment,
                                                           TraceCounts& counts) const {
  if (segment.begun == kNoTriangle) {
    ++counts.rays;
    if (!rays_.occluded(segment.origin - slack_ * segment.direction, segment.direction,
                        static_cast<float>(segment.length + 2 * slack_)))
      return std::nullopt;
  }
  float from = 0;
  const auto next = nextOn(segment, from, counts);
  return next && next->distance <= segment.length ? next : std::nullopt;
}

std::optional<RandomWalk::Boundary> RandomWalk::nextOn(const Segment& segment, float& from,
                                                       TraceCounts& counts) const {
  const Vec3 origin = segment.origin - slack_ * segment.direction;
  // A line meets a triangle once, so this ends.
  while (true) {
    ++counts.rays;
    const Hit hit = rays_.nearestHit(origin, segment.direction, from);
    if (!hit.valid || hit.distance > segment.length + 2 * slack_) return std::nullopt;
    from = std::nextafter(hit.distance, std::numeric_limits<float>::infinity());
    if (hit.triangle == segment.begun) continue;
    if (hit.triangle >= mesh_.triangleCount()) {  // an emitter
      if (hit.distance < slack_) continue;
      return Boundary{hit.distance - slack_, hit};
    }
    const Vec3 cross = crossOf(hit.triangle);
    const double distance =
        cross.dot(cornerOf(hit.triangle, 0) - segment.origin) / cross.dot(segment.direction);
    // False for a triangle that the segment lies in.
    if (distance >= segment.least) return Boundary{distance, hit};
  }
}

// Of closed meshes any line tells it.
int RandomWalk::windingAhead(const Segment& segment, TraceCounts& counts) const {
  Segment line = segment;
  line.length = std::numeric_limits<double>::infinity();
  int winding = 0;
  float from = 0;
  while (const auto next = nextOn(line, from, counts))
    if (next->hit.triangle < mesh_.triangleCount()) winding += next->hit.back_face ? 1 : -1;
  return winding;
}

std::optional<RandomWalk::Exit> RandomWalk::walk(const Start& start, const Vec3& direction,
                                                 std::uint64_t seed, TraceCounts& counts) const {
  RandomNumbers random(seed);
  Rgb weight = Rgb::Ones();
  Segment segment{start.position, direction, 0, slack_ * (kRounding / kSlack), start.triangle};
  ++counts.walks;
  // 0 where a face lies doubled, here or there, and below sheets: the right way round, then.
  const bool inside_out = windingAhead(segment, counts) < 0;
  for (int event = 0; event < kMostEvents; ++event) {
    const Eigen::Index color = drawnColor(weight, random.next());
    segment.length = lengthOf(segment, color, -std::log1p(-random.next()));
    const auto boundary = boundaryOn(segment, counts);
    const double length = boundary ? boundary->distance : segment.length, before = weight.sum();
    const Rgb left = weight * attenuated(depthOf(segment, length));
    const Vec3 place = field_.isUniform() ? segment.origin : lastMiddle(segment, length);
    segment.origin += length * segment.direction;
    segment.least = 0;

    if (!boundary) {
      if (!withinBounds(segment.origin)) {
        ++counts.open_walks;
        return std::nullopt;
      }
      weight = left * scatteringAt(place) * (before / (left * extinctionAt(place)).sum());
      const double mean = weight.sum() / 3;
      if (mean < kRouletteBelow) {
        if (random.next() * kRouletteBelow >= mean) return std::nullopt;
        weight *= kRouletteBelow / mean;
      }
      segment.direction = uniformDirection(random);
      segment.begun = kNoTriangle;
      continue;
    }

    weight = left * (before / left.sum());
    Hit hit = boundary->hit;
    if (hit.triangle >= mesh_.triangleCount() || (!of_medium_.empty() && of_medium_[hit.triangle] == 0))
      return std::nullopt;
    segment.begun = hit.triangle;
    // Into one more body, or out of one of several.
    if (hit.back_face == inside_out || windingAhead(segment, counts) * (inside_out ? -1 : 1) > 0) continue;
    const Vec3 normal = crossOf(hit.triangle).normalized();
    const double along = normal.dot(segment.direction);
    if (random.next() >= transport::fresnelReflectance(std::abs(along), 1 / relative_ior_)) {
      hit.back_face = inside_out;
      return Exit{hit, weight};
    }
    segment.direction = (segment.direction - 2 * along * normal).normalized();
  }
  ++counts.cut_walks;
  return std::nullopt;
}

}  // namespace bakelight::reference
