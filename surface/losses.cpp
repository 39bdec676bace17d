#include "surface/losses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "formats/error.h"

namespace bakelight::surface {

using Box = Eigen::AlignedBox3d;
using formats::Float3;
using formats::TriangleMesh;
using transport::vec3;

namespace {

constexpr float kFarthest = 1e18f;
constexpr double kSmallest = 1e-18;
constexpr std::size_t kSmallShareDivisor = 100;  // of triangles: fewer are not worth a word
constexpr std::size_t kTailDivisor = 100;        // of vertices, on each end of an axis
constexpr double kFarOut = 1000;                 // ÷ the bulk's diagonal
constexpr double kFineFloats = 0.02;             // distance of floats ÷ edges' length

std::string number(double value) {
  return fmt::format("{:.6g}", value);
}

std::string placeText(const Vec3& p) {
  return "(" + number(p.x()) + ", " + number(p.y()) + ", " + number(p.z()) + ")";
}

// "160 of 320 triangles (50 %), between (0, 0, 0) and (1, 1, 1),"
std::string shareText(std::size_t count, std::size_t all, const Box& box) {
  const double percent = 100 * static_cast<double>(count) / static_cast<double>(all);
  return fmt::format("{} of {} triangles ({:.2g} %), between {} and {},", count, all, percent,
                     placeText(box.min()), placeText(box.max()));
}

bool isLarge(std::size_t count, std::size_t all) {
  return count > all / kSmallShareDivisor && count > 0;
}

struct Group {
  std::size_t count = 0;
  Box box;
  void add(const TriangleMesh& mesh, const formats::Triangle& t) {
    ++count;
    for (const std::uint32_t v : t) box.extend(vec3(mesh.positions[v]));
  }
};

// Triangles of three vertices whose corners coincide, in floats or once welded.
struct Collapsed {
  Group in_floats, by_weld;
};

Collapsed collapsed(const TriangleMesh& mesh, double weld_tolerance) {
  std::vector<Vec3> positions;
  positions.reserve(mesh.vertexCount());
  for (const Float3& p : mesh.positions) positions.push_back(vec3(p));
  const std::vector<std::uint32_t> welded = weldedVertices(positions, weld_tolerance);
  Collapsed result;
  for (const formats::Triangle& t : mesh.triangles) {
    bool in_floats = false, by_weld = false;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (a == b) continue;
      in_floats |= mesh.positions[a] == mesh.positions[b];
      by_weld |= welded[a] == welded[b];
    }
    if (in_floats)
      result.in_floats.add(mesh, t);
    else if (by_weld)
      result.by_weld.add(mesh, t);
  }
  return result;
}

double medianEdge(const TriangleMesh& mesh) {
  std::vector<double> lengths;
  for (const formats::Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = (vec3(mesh.positions[t[k]]) - vec3(mesh.positions[t[(k + 1) % 3]])).norm();
      if (length > 0) lengths.push_back(length);
    }
  if (lengths.empty()) return 0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

// Between neighbouring floats, where the box is farthest from the origin.
double floatSpacing(const Box& box) {
  const auto farthest =
      static_cast<float>(std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()));
  return std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest;
}

// The vertex farthest from the bulk.
std::uint32_t farthestVertex(const TriangleMesh& mesh, const Box& bulk) {
  std::uint32_t farthest = mesh.triangles.front()[0];
  for (const formats::Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      if (bulk.squaredExteriorDistance(vec3(mesh.positions[v])) >
          bulk.squaredExteriorDistance(vec3(mesh.positions[farthest])))
        farthest = v;
    }
  return farthest;
}

void warnOfFarVertex(const TriangleMesh& mesh, const Extent& extent, std::vector<std::string>& warnings) {
  if (!extent.bulk) return;
  const std::uint32_t v = farthestVertex(mesh, *extent.bulk);
  const Vec3 place = vec3(mesh.positions[v]);
  warnings.push_back("vertex " + std::to_string(v) + " at " + placeText(place) + " lies " +
                     number(extent.bulk->exteriorDistance(place)) +
                     " away from the bulk of the mesh, between " + placeText(extent.bulk->min()) + " and " +
                     placeText(extent.bulk->max()) +
                     ": delete it if it is astray, as the size of the whole is taken for that of the body");
}

}  // namespace

void checkScale(const TriangleMesh& mesh, const std::string& file) {
  Box box;
  for (const formats::Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      for (const float x : mesh.positions[v]) {
        if (std::abs(x) > kFarthest)
          throw badInput({file, "vertex " + std::to_string(v), ""}, "a coordinate is " + number(x),
                         "coordinates within 1e18",
                         "scale the mesh down, or delete the vertex if it is astray");
      }
      box.extend(vec3(mesh.positions[v]));
    }
  const double diagonal = box.diagonal().norm();
  if (diagonal > 0 && diagonal < kSmallest)
    throw badInput({file, "", ""}, "the mesh is " + number(diagonal) + " units across", "at least 1e-18",
                   "scale the mesh up");
}

Extent extentOf(const WorkingMesh& mesh) {
  Extent extent;
  std::vector<bool> used(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) used[v] = true;
  }
  std::vector<double> coordinates;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (used[v]) extent.box.extend(mesh.positions[v]);
  }
  Box bulk;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    coordinates.clear();
    for (std::size_t v = 0; v < used.size(); ++v) {
      if (used[v]) coordinates.push_back(mesh.positions[v][axis]);
    }
    const auto tail = static_cast<std::ptrdiff_t>(coordinates.size() / kTailDivisor);
    const auto first = coordinates.begin() + tail, last = coordinates.end() - 1 - tail;
    std::nth_element(coordinates.begin(), first, coordinates.end());
    low[axis] = *first;
    std::nth_element(coordinates.begin(), last, coordinates.end());
    high[axis] = *last;
  }
  bulk.extend(low).extend(high);
  const double diagonal = bulk.diagonal().norm();
  if (diagonal > 0 && extent.box.diagonal().norm() > kFarOut * diagonal) extent.bulk = bulk;
  return extent;
}

std::vector<std::string> lossWarnings(const TriangleMesh& mesh, const Extent& extent, double weld_tolerance,
                                      const RepairCounts& counts) {
  std::vector<std::string> warnings;
  const std::size_t all = mesh.triangleCount();
  warnOfFarVertex(mesh, extent, warnings);
  const double spacing = floatSpacing(extent.working()), edge = medianEdge(mesh);
  const bool coarse = spacing > kFineFloats * edge;
  const bool many = isLarge(static_cast<std::size_t>(counts.repeated_index_triangles), all);
  const Collapsed lost = coarse || many ? collapsed(mesh, weld_tolerance) : Collapsed();
  if (coarse) {
    std::string text = "coordinates are so far from the origin that floats are " + number(spacing) +
                       " apart, where edges are " + number(edge) + " long: ";
    text += lost.in_floats.count > 0
                ? shareText(lost.in_floats.count, all, lost.in_floats.box) + " collapsed and were removed"
                : "the surface is rounded to steps";
    warnings.push_back(text + "; move the mesh to the origin before it is exported");
  }
  if (isLarge(lost.by_weld.count, all))
    warnings.push_back(shareText(lost.by_weld.count, all, lost.by_weld.box) + " have corners closer than " +
                       number(weld_tolerance) +
                       ", which are welded, and were removed; a lower weld_tolerance keeps them");
  if (isLarge(static_cast<std::size_t>(counts.duplicate_triangles), all))
    warnings.push_back(shareText(static_cast<std::size_t>(counts.duplicate_triangles), all, extent.box) +
                       " repeat others and were removed");
  if (isLarge(static_cast<std::size_t>(counts.lost_backs), all))
    warnings.push_back(
        shareText(static_cast<std::size_t>(counts.lost_backs), all, extent.box) +
        " lie back to back on others and were removed, so that these have one side only; where "
        "both sides are to be seen, give the sheet vertices of its own, or set double_sided");
  if (counts.inside_out_components > 0)
    warnings.push_back(std::to_string(counts.inside_out_components) +
                       (counts.inside_out_components == 1 ? " closed part" : " closed parts") +
                       " faced inwards and had the sides of all triangles exchanged");
  return warnings;
}

std::vector<std::string> roundingWarnings(const TriangleMesh& result) {
  Group lost;
  for (const formats::Triangle& t : result.triangles) {
    const Float3 &a = result.positions[t[0]], &b = result.positions[t[1]], &c = result.positions[t[2]];
    if (a == b || b == c || c == a) lost.add(result, t);
  }
  if (lost.count == 0) return {};
  return {
      shareText(lost.count, result.triangleCount(), lost.box) +
      " of the result have no area, as floats are too coarse there; move the mesh to the origin before it "
      "is exported"};
}

}  // namespace bakelight::surface
