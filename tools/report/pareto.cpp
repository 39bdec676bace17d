#include "tools/report/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace bakelight::report {

std::vector<std::size_t> paretoFront(std::span<const CostAndError> points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].cost) && std::isfinite(points[i].error)) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(points[a].cost, points[a].error) < std::tie(points[b].cost, points[b].error);
  });
  std::vector<std::size_t> front;
  for (const std::size_t i : order) {
    const bool first = front.empty();
    const CostAndError best =
        first ? CostAndError{0, std::numeric_limits<double>::infinity()} : points[front.back()];
    const bool equal = !first && points[i].cost == best.cost && points[i].error == best.error;
    if (points[i].error < best.error || equal) front.push_back(i);
  }
  return front;
}

}  // namespace bakelight::report
