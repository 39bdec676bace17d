#include "tools/neighborhood/grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bakelight::neighborhood {
namespace {

constexpr double kInnerShare = 0.6;  // of the intervals along an axis, across the object itself

struct Box {
  transport::Vec3 low = transport::Vec3::Constant(std::numeric_limits<double>::infinity());
  transport::Vec3 high = -low;
};

Box boundingBox(const formats::TriangleMesh& mesh) {
  Box box;
  for (const formats::Float3& position : mesh.positions) {
    box.low = box.low.cwiseMin(transport::vec3(position));
    box.high = box.high.cwiseMax(transport::vec3(position));
  }
  return box;
}

// Intervals of about `spacing`, on both sides `outer` more up to `reach`. A flat object has a width, too.
std::vector<float> axisAround(double low, double high, double spacing, int outer, double reach) {
  const double least = spacing / 2;
  if (high - low < 2 * least) {
    const double middle = (low + high) / 2;
    low = middle - least, high = middle + least;
  }
  const int inner = std::max(1, static_cast<int>(std::lround((high - low) / spacing)));
  return gradedAxis(low, high, inner, outer, reach);
}

}  // namespace

std::vector<float> gradedAxis(double low, double high, int inner, int outer, double reach) {
  const double spacing = (high - low) / inner;
  const auto extent = [&](double factor) {
    double sum = 0, step = spacing;
    for (int i = 0; i < outer; ++i) sum += step *= factor;
    return sum;
  };
  double factor = 1, first = spacing;
  if (extent(1) >= reach) {
    first = reach / outer;
  } else {
    double above = 2;
    while (extent(above) < reach) above *= 2;
    for (int i = 0; i < 60; ++i)
      (extent((factor + above) / 2) < reach ? factor : above) = (factor + above) / 2;
  }
  std::vector<double> steps;
  for (double step = first * factor; static_cast<int>(steps.size()) < outer; step *= factor)
    steps.push_back(step);

  std::vector<float> axis;
  double at = low;
  for (const double step : steps) axis.push_back(static_cast<float>(at -= step));
  std::reverse(axis.begin(), axis.end());
  for (int i = 0; i <= inner; ++i) axis.push_back(static_cast<float>(low + spacing * i));
  at = high;
  for (const double step : steps) axis.push_back(static_cast<float>(at += step));
  return axis;
}

GroundGrid groundGrid(const formats::TriangleMesh& mesh, const transport::BoundingSphere& bounds, int cells,
                      double reach) {
  const Box box = boundingBox(mesh);
  const int inner = std::max(1, static_cast<int>(std::lround(kInnerShare * cells)));
  const int outer = std::max(1, (cells - inner) / 2);
  const double spacing =
      std::max({box.high.x() - box.low.x(), box.high.z() - box.low.z(), bounds.radius / cells}) / inner;
  const double length = reach * bounds.radius;
  return {static_cast<float>(box.low.y()), axisAround(box.low.x(), box.high.x(), spacing, outer, length),
          axisAround(box.low.z(), box.high.z(), spacing, outer, length)};
}

std::array<std::vector<float>, 3> volumeGrid(const formats::TriangleMesh& mesh,
                                             const transport::BoundingSphere& bounds, int cells,
                                             double reach) {
  const Box box = boundingBox(mesh);
  const double length = reach * bounds.radius;
  const double spacing = ((box.high - box.low).maxCoeff() + 2 * length) / cells;
  std::array<std::vector<float>, 3> axes;
  for (int a = 0; a < 3; ++a) {
    // Nothing is below the plane that the object stands on.
    const double low = a == 1 ? box.low.y() : box.low[a] - length, high = box.high[a] + length;
    const int count = std::max(1, static_cast<int>(std::lround((high - low) / spacing)));
    for (int i = 0; i <= count; ++i) axes[a].push_back(static_cast<float>(low + (high - low) * i / count));
  }
  return axes;
}

}  // namespace bakelight::neighborhood
