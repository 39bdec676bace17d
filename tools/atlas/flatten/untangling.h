// Mends what little keeps a flat chart from being one-to-one.
#pragma once

#include <vector>

#include "tools/atlas/charts/chart.h"

namespace bakelight::atlas {

bool hasFlipped(const Chart& chart, const std::vector<Vec2>& plane);

// Moves vertices of flipped triangles to where none around them is flipped, as little as that takes: each to
// the half-planes beyond the edges opposite to it, by projections in turn (Agmon 1954), in a few sweeps.
// Meant for few: returns false if some are left, or if there are more than one in a hundred. Cost: O(n), and
// some 10 µs a flipped triangle.
bool untangle(const Chart& chart, std::vector<Vec2>& plane);

// Where a border crosses itself within a few edges, as at the mouth of a notch, draws it flat or opens it
// until it does not, and turns small holes the right way, as far as no triangle is flipped. None may be
// flipped before. Returns false, and leaves the plane as it is, if borders still cross somewhere, if they do
// so elsewhere, or in more than a few places. Cost: O(n + borders · log(borders)) a sweep.
bool uncrossBorders(const Chart& chart, std::vector<Vec2>& plane);

}  // namespace bakelight::atlas
