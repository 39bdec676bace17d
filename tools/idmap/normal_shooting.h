// Which vertex of a meso-mesh a point of a surface looks up (Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance
// Transfer", section 4.3: normal shooting).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::idmap {

using formats::Float3;

// What is looked up in. Vertices at the same place count as connected.
struct MesoSurface {
  const formats::TriangleMesh& mesh;         // with normals
  std::span<const std::uint32_t> materials;  // of vertices; empty: all alike
};

struct Shot {
  Float3 position;
  Float3 normal;                               // unit length
  std::optional<std::uint32_t> material = {};  // only vertices of it count
  bool required = true;                        // else farther vertices are not looked for
};

// What was found on the way; sums and maxima do not depend on the order of shots.
struct ShotFigures {
  std::uint64_t shots = 0;
  std::uint64_t widened = 0;       // had to look at more than k vertices to find one that faces their way
  std::uint64_t other_sheets = 0;  // did not take the vertex nearest to the line, as it is of another sheet
  double offset_sum = 0;           // of the vertex from the point, in units of length
  double distance_sum = 0, farthest = 0;  // of the vertex from the line through the point, in units of length

  void add(const ShotFigures& more);
};

class NormalShooting {
 public:
  static constexpr std::size_t kMostNeighbors = 4096;

  // Copies what it needs. `neighbors`: k, at least 1; more than there are vertices means all of them. Cost:
  // O(vertices · log vertices).
  NormalShooting(const MesoSurface& surface, std::size_t neighbors);
  ~NormalShooting();
  NormalShooting(const NormalShooting&) = delete;
  NormalShooting& operator=(const NormalShooting&) = delete;

  // For each shot the vertex that is nearest to the line along its normal, among those of the k nearest that
  // face the same way (a positive cosine), are of its material and hang together with the one that is
  // nearest when height counts four times: sheets that lie closer than the search reaches are told apart by
  // their facing and by the mesh. Of equally near ones the first vertex. Where none of k faces that way, k is
  // quadrupled for a shot that is required, to kMostNeighbors at most; kNone if there is none even so, and then the
  // shots after a required one are not looked at: figures.shots says how many were. Thread-safe. About 1 µs a
  // shot if shots side by side are near each other (FLANN's exact k-d tree is half of it).
  static constexpr std::uint32_t kNone = 0xffffffffU;
  ShotFigures shoot(std::span<const Shot> shots, std::span<std::uint32_t> vertices) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace bakelight::idmap
