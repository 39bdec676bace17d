// One edge collapse: what it costs, whether it may be, and doing it.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/corner_mesh.h"

namespace bakelight::surface {

// How far the constraints had to be given up to reach the target.
enum class DecimationLevel { kFull, kWithoutCreases, kUnconstrained };

// Vertices of at least this many triangles; what happens next to one is not done by threads at once.
inline constexpr std::uint32_t kHubTriangles = 24;

struct Collapse {
  float cost = 0;
  std::uint32_t onto = kNone;  // the neighbour that the vertex is drawn onto; kNone: none is allowed
  bool near_hub = false;       // the vertex or a neighbour is a hub
};

class Collapses {
 public:
  // Reads positions and features of `mesh`, which must outlive this. All TBB threads.
  explicit Collapses(CornerMesh& mesh);

  // Room for what find() gathers, one a thread.
  struct Workspace {
    std::vector<std::uint32_t> neighbors, sorted_neighbors;
    std::vector<Side> sides;  // that start at the vertex, counter-clockwise
    std::vector<float> costs;
    bool border = false;
  };

  // The cheapest collapse of `vertex` that is allowed.
  Collapse find(std::uint32_t vertex, DecimationLevel level, Workspace& work) const;
  // Whether topology allows to draw `vertex` onto its neighbour.
  bool keepsTopology(std::uint32_t vertex, std::uint32_t onto, Workspace& work) const;
  // Writes to the vertex, its neighbours and the triangles around it, and to the opposites of those next to
  // them. Returns how many triangles are gone: 2, or 1 on the border.
  std::size_t apply(std::uint32_t vertex, std::uint32_t onto, Workspace& work);

 private:
  // Area-weighted squared distances from planes, and the area they stand for: their ratio is a mean squared
  // distance. xᵀAx + 2bᵀx + c.
  struct Error {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    Vec3 b = Vec3::Zero();
    double c = 0, area = 0;

    void addPlane(const Vec3& normal, const Vec3& point, double weight);
    Error& operator+=(const Error& other);
    double at(const Vec3& p) const;
  };
  void gather(std::uint32_t vertex, Workspace& work) const;
  bool gatheredKeepTopology(std::uint32_t vertex, std::uint32_t onto, const Workspace& work) const;
  bool keepsNormals(std::uint32_t vertex, std::uint32_t onto, const Workspace& work) const;
  Error initialError(std::uint32_t vertex, const std::vector<Vec3>& normals) const;

  CornerMesh& mesh_;
  std::vector<Error> errors_;
  std::vector<std::uint32_t> valence_;  // neighbours of each vertex
};

}  // namespace bakelight::surface
