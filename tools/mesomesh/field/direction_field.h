// A smooth field of tangent directions over a mesh, the same when turned by 360°/symmetry.
//
// The smoothest field of all (Knöppel, Crane, Pinkall & Schröder, Globally Optimal Direction Fields, 2013: the
// smallest eigenvector of the connection Laplacian) on a graph of a few thousand clusters of vertices, carried
// over to finer and finer clusters and smoothed there (Jakob, Tarini, Panozzo & Sorkine-Hornung, Instant
// Field-Aligned Meshes, 2015).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::mesomesh {

// What the user asks for: at the vertex nearest to the point the field is the direction, projected into its
// tangent plane, and near there it follows.
struct DirectionHint {
  formats::Float3 point, direction;
};

// A JSON list of {"point": [x, y, z], "direction": [x, y, z]}. Throws Error(kBadInput) with the pointer of
// what is malformed, or of a direction without length.
std::vector<DirectionHint> readHints(const std::filesystem::path& path);

struct FieldOptions {
  int symmetry = 1;  // 1, 2, 4
  // Across features whose normals differ by more than this the field is not transported. Vertices at the same
  // place whose normals are nearer than that count as joined.
  double crease_angle_deg = 80;
};

struct Singularity {
  std::uint32_t triangle = 0;
  int index = 0;  // in units of 1/symmetry of a turn
};

struct DirectionField {
  std::vector<formats::Float3> tangents;   // of each vertex, unit, perpendicular to the normal
  std::vector<Singularity> singularities;  // by triangle
  // On a closed mesh without creases it is symmetry × the Euler characteristic.
  std::int64_t index_sum = 0;
  std::map<std::string, double> seconds;  // by step
  std::vector<std::string> warnings;      // of hints
};

// `mesh` with unit normals; triangles index its vertices. Throws Error(kBadInput) naming `hints_file`, and the
// hint, for a direction along the normal of the surface. The same bytes for any number of threads; linear.
DirectionField directionField(const formats::TriangleMesh& mesh, const FieldOptions& options,
                              std::span<const DirectionHint> hints, const std::string& hints_file);

}  // namespace bakelight::mesomesh
