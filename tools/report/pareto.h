// Which variants nothing beats.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace bakelight::report {

struct CostAndError {
  double cost, error;
};

// Indices of the points that no other one dominates (at most their cost and at most their error, and less in
// one of them), by rising cost; equal points are all in. Points that are not finite are out.
std::vector<std::size_t> paretoFront(std::span<const CostAndError> points);

}  // namespace bakelight::report
