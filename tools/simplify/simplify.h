// The simplify stage: from whatever a modeller or scanner delivers to a clean mesh of a given number of round
// triangles.
//
// Repair (repair.h) → edge collapse with quadric errors (decimate.h) → edge flips and tangential relaxation
// on the original surface, then a least-squares fit to it (relax.h) → angle-weighted normals, split along
// creases and borders between materials (normals.h).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "formats/triangle_mesh.h"
#include "surface/metrics.h"
#include "surface/repair.h"
#include "tools/simplify/small_parts.h"
#include "tools/simplify/surface_words.h"

namespace bakelight::simplify {

struct SimplifyOptions {
  int triangles = 20000;         // target, ≥ 4; a mesh with no more is repaired but not decimated
  bool refine = false;           // a mesh with fewer gets that many, too: its surface stays as it is
  double least_part = 0;         // parts with less of the area, 0–1, are left out
  double weld_tolerance = 1e-7;  // ÷ bounding-box diagonal (of the bulk); 0: only exactly coincident vertices
  double crease_angle_deg = 80;  // edges sharper than this keep their place and are shaded flat
  int relax_rounds = 8;          // 0: no flips, moves or fit
};

struct SimplifyReport {
  RepairCounts repairs;
  SmallParts small_parts;
  Topology topology_in, topology_out;  // after the repair, after the whole stage
  std::int64_t vertices_in = 0, vertices_out = 0, triangles_in = 0, triangles_out = 0;
  std::int64_t crease_edges = 0, corners = 0;         // kept in place by decimation
  std::int64_t materials = 0;                         // that triangles of the result have
  std::int64_t material_edges = 0;                    // between two materials, kept in place, too
  std::int64_t splits = 0, collapses = 0, flips = 0;  // of edges
  std::int64_t split_vertices = 0;                    // copies along creases, for flat shading
  std::int64_t material_vertices = 0;                 // copies along borders between materials
  std::int64_t seam_vertices = 0;                     // copies along seams of the texture coordinates
  std::string constraints;  // decimation level: what had to be given up (decimate.h)
  AngleQuality angles_in, angles_out;
  double area_in = 0, area_out = 0, volume_in = 0, volume_out = 0;  // unit of length squared, cubed
  Deviation deviation;                                              // ÷ bounding-box diagonal
  std::map<std::string, double> seconds;                            // by step
  std::vector<std::string> left_out;  // steps that were not run, with the reason
  std::vector<std::string> warnings;
};

struct SimplifyResult {
  // With normals and materials; without colours (colors.h). With the input's texcoords unless triangles had
  // to change. No vertex belongs to two materials.
  formats::TriangleMesh mesh;
  SimplifyReport report;
};

// Deterministic: the same bytes for any number of threads. Works in double precision about the bounding box's
// centre, so units and offsets do not matter beyond the input's own rounding. Throws Error(kBadInput) naming
// `file` and element for an index out of range, a position that is not finite or too far out (losses.h), no
// triangle, or none left after the repair. All TBB threads; linear in the number of triangles.
SimplifyResult simplify(const formats::TriangleMesh& mesh, const SimplifyOptions& options,
                        const std::string& file);

}  // namespace bakelight::simplify
