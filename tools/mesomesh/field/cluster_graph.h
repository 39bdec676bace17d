// Vertices joined to clusters, clusters to larger ones, and how directions are carried between neighbours.
#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "formats/triangle_mesh.h"
#include "transport/vector_types.h"

namespace bakelight::mesomesh {

using transport::Vec3;
using Complex = std::complex<double>;

// A direction in a tangent plane is a complex number in the plane's axes `axis` and normal × axis; its power
// `symmetry` is the same for all directions that the symmetry takes for one.
struct ClusterLevel {
  std::vector<Vec3> normals, axes;  // of each node, unit
  std::vector<double> masses;       // vertices in it
  // Neighbours of node i: from first[i] to before first[i + 1], in index order, both ways, with equal weights.
  std::vector<std::uint32_t> first, neighbors;
  std::vector<float> weights;
  std::vector<std::uint32_t> cluster;  // of each node, in the next level; empty in the last one

  std::size_t size() const { return normals.size(); }
};

// What a direction's power in the plane of `from` is multiplied by to be carried by the least rotation into
// that of `to`; 0 where the normals are opposite. There and back is 1.
Complex carried(const ClusterLevel& from, std::size_t from_node, const ClusterLevel& to, std::size_t to_node,
                int symmetry);

// The vertices themselves first, the last with at most `most_nodes` or where no more can be joined. Neighbours
// are the ends of edges, and vertices at one place whose normals are nearer than `crease_angle_deg`. All TBB
// threads; linear.
std::vector<ClusterLevel> clusterLevels(const formats::TriangleMesh& mesh, double crease_angle_deg,
                                        std::size_t most_nodes);

}  // namespace bakelight::mesomesh
