#include "tools/atlas/maps/border_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bakelight::atlas {
namespace {

// Far more than any way of some texels crosses; ends a walk that rounding turns in a circle.
constexpr int kMostTriangles = 10000;

// Where a walk leaves a triangle, or enters one: on edge k, `along` of the way from its corner k.
struct Crossing {
  std::uint32_t triangle;
  std::size_t k;
  double along;
};

Vec3 edgeDirection(const Surface& surface, const Crossing& at) {
  return (surface.corner(at.triangle, (at.k + 1) % 3) - surface.corner(at.triangle, at.k)).normalized();
}

// The same point as seen by the triangle across the edge.
std::optional<Crossing> otherSide(const Surface& surface, const Crossing& at) {
  const std::int32_t neighbor = surface.neighbors[at.triangle][at.k];
  if (neighbor < 0) return std::nullopt;
  const std::uint32_t end = surface.triangles[at.triangle][(at.k + 1) % 3];
  for (std::size_t k = 0; k < 3; ++k)
    if (surface.neighbors[neighbor][k] == static_cast<std::int32_t>(at.triangle) &&
        surface.triangles[neighbor][k] == end)
      return Crossing{static_cast<std::uint32_t>(neighbor), k, 1 - at.along};
  return std::nullopt;
}

// How the weights of the triangle's corners change along `direction`, by length.
Vec3 weightChange(const Surface& surface, std::uint32_t triangle, const Vec3& direction) {
  Vec3 change;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 opposite = surface.corner(triangle, (i + 2) % 3) - surface.corner(triangle, (i + 1) % 3);
    change[i] = surface.normals[triangle].cross(opposite).dot(direction) / (2 * surface.areas[triangle]);
  }
  return change;
}

}  // namespace

std::optional<WalkEnd> walkAcross(const Surface& surface, std::uint32_t triangle, std::size_t k, double along,
                                  double forward, double outward) {
  double remaining = std::hypot(forward, outward);
  forward /= remaining, outward /= remaining;
  Crossing leaving = {triangle, k, along};
  for (int step = 0; step < kMostTriangles; ++step) {
    // Into the neighbour, turned about the edge; it runs along the edge the other way.
    const std::optional<Crossing> entered = otherSide(surface, leaving);
    if (!entered) return std::nullopt;
    const std::uint32_t t = entered->triangle;
    const Vec3 edge = edgeDirection(surface, *entered);
    const Vec3 direction = -forward * edge + outward * surface.normals[t].cross(edge);
    Vec3 weights = Vec3::Zero();
    weights[entered->k] = 1 - entered->along;
    weights[(entered->k + 1) % 3] = entered->along;

    // To the first of the other two edges.
    const Vec3 change = weightChange(surface, t, direction);
    double way = std::numeric_limits<double>::infinity();
    std::size_t corner = 0;  // opposite to that edge
    for (const std::size_t i : {entered->k, (entered->k + 1) % 3})
      if (change[i] < 0 && -weights[i] / change[i] < way) way = -weights[i] / change[i], corner = i;
    if (way >= remaining) {
      weights = (weights + remaining * change).cwiseMax(0);
      return WalkEnd{t, weights / weights.sum(), direction};
    }
    remaining -= way;
    weights = (weights + way * change).cwiseMax(0);
    const std::size_t next = (corner + 1) % 3;
    leaving = {t, next, weights[(next + 1) % 3] / (weights[next] + weights[(next + 1) % 3])};
    const Vec3 leaving_edge = edgeDirection(surface, leaving);
    forward = direction.dot(leaving_edge);
    outward = std::max(direction.dot(leaving_edge.cross(surface.normals[t])), 0.0);
  }
  return std::nullopt;
}

}  // namespace bakelight::atlas
