// Cuts and corners that a person chose: listed in a JSON file, or marked as edges in the mesh's own file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// A vertex of the mesh, or a position in the mesh file's coordinates, which stands for the vertex nearest to
// it.
using CutPoint = std::variant<std::uint32_t, Vec3>;

struct Cuts {
  std::vector<std::vector<CutPoint>> lines;  // two points or more each
  std::vector<CutPoint> corners;             // of convex charts (convex_boundary.h)
};

// {"cuts": [[point, point, …], …], "corners": [point, …]}, either may be missing; a point is a vertex number,
// counted from 0, or a position [x, y, z]. Throws Error(kBadInput) naming `file` and the place in it: another
// key, another type, a line of fewer than two points.
Cuts cutsFromJson(const nlohmann::json& json, const std::string& file);
Cuts readCuts(const std::filesystem::path& path);

struct AppliedCuts {
  std::vector<std::uint32_t> corner_places;  // ascending
  std::int64_t edges = 0;                    // cut
};

// Cuts the edges along each line; points that no edge joins are joined by the shortest path along edges.
// Throws Error(kBadInput) naming `file` and the point: a vertex out of range or of no triangle that has an
// area, a position farther from any than 1% of the bounding box's diagonal, two points on parts that do not
// hang together. Cost: O(n log n) a path, O(n) a position.
AppliedCuts applyCuts(Surface& surface, const Cuts& cuts, const std::string& file);

struct MarkedEdges {
  std::int64_t cut = 0;
  std::int64_t unknown = 0;  // no triangle that has an area has them
};
// Edges between vertices of the mesh, in range, as formats::readPlyEdges reads them.
MarkedEdges cutMarkedEdges(Surface& surface, std::span<const std::array<std::uint32_t, 2>> edges);

}  // namespace bakelight::atlas
