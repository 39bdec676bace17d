// A surface of about the same shape with fewer triangles, on which charts are found sooner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

struct Proxy {
  // Its unit of length is the original's, so that its area is about 1. Marks, borders and where parts of the
  // surface hang together are the original's; `source_triangles` name triangles of the original, and its
  // places are some of the original's.
  Surface surface;
};

// Half-edge collapses in the order of quadric errors (Garland & Heckbert 1997), down to `triangles` if
// topology and shape allow. Vertices of borders, marked and non-manifold edges stay. Deterministic, on one
// thread. Cost: O(n log n), some 3 µs a triangle.
Proxy proxyOf(const Surface& surface, std::size_t triangles);

// For each of the original's triangles the proxy's that is the fewest steps across edges that may be passed
// away within the region; −1 if none can be reached.
std::vector<std::int32_t> nearestOfProxy(const Surface& surface, std::span<const std::int32_t> regions,
                                         const Proxy& proxy);

}  // namespace bakelight::atlas
