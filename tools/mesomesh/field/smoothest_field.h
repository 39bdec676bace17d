// The smoothest field on the nodes of one graph.
#pragma once

#include <map>
#include <vector>

#include "tools/mesomesh/field/cluster_graph.h"

namespace bakelight::mesomesh {

// Powers of directions (cluster_graph.h) that nodes are held to, of length 1.
using Held = std::map<std::uint32_t, Complex>;

// For each node the power of a direction: in each connected part the eigenvector of Σ w |z_i − carried(z_j)|²
// with the least eigenvalue, by inverse iteration; where nodes are held, the least of that sum. One sparse
// factorisation: a few thousand nodes. Lengths are of no meaning; 0 at singularities.
std::vector<Complex> smoothestField(const ClusterLevel& level, int symmetry, const Held& held);

// Each node takes the mean of its neighbours and of itself, of length 1, `sweeps` times. All TBB threads.
void smoothField(const ClusterLevel& level, int symmetry, const Held& held, int sweeps,
                 std::vector<Complex>& field);

}  // namespace bakelight::mesomesh
