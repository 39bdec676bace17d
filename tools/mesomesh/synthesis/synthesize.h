// Texture synthesis over a surface: a place of an exemplar for each vertex, such that the surface looks like
// the exemplar everywhere and repeats it nowhere. Appearance-space k-coherence (Lefebvre & Hoppe 2006,
// "Appearance-space texture synthesis"; Tong et al. 2002, "Synthesis of bidirectional texture functions on
// arbitrary surfaces"), or exhaustive search (Turk 2001, "Texture synthesis on surfaces").
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/mesomesh/synthesis/exemplar.h"
#include "tools/mesomesh/synthesis/quality.h"
#include "tools/mesomesh/synthesis/surface_graph.h"

namespace bakelight::mesomesh {

enum class SynthesisMethod {
  kCoherent,
  kFull  // exhaustive, on one thread: for meshes of some thousand vertices, as the measure of the other
};

struct SynthesisOptions {
  SynthesisMethod method = SynthesisMethod::kCoherent;
  // Of the field that tangents follow. Where frames turn between neighbors, the exemplar is turned onto
  // itself as it suits it best; unless it has the symmetry (ExemplarSymmetry::folds), a seam is left there.
  FieldFolds folds = FieldFolds::kOne;
  std::uint64_t seed = 0;
  // How far coordinates are moved at random while they are coarse, 0–1. At 0 the exemplar is tiled wherever
  // the surface admits it.
  double randomness = 1;
  // Corrections of each level (twice as many at the coarsest), and how many similar places of each candidate
  // they try, 0–7.
  int passes = 4;
  int similar = 3;
  // Into how many pieces each class of vertices is cut that may be corrected at once, 0: as suits the machine.
  // The outcome depends on it as little as on threads.
  std::size_t ranges = 0;
  bool measure_quality = true;
  // For seam_ratio, of each of the mesh's vertices: 1 near a seam. Empty: vertices of which the mesh has
  // several at a place (as cuts of an atlas leave), whose frame is turned to a neighbor's, or at a border of
  // exemplars: wherever the mesh or the field has a cut that the texture should not show.
  std::span<const std::uint8_t> on_seam = {};
};

struct SynthesisReport {
  struct Level {
    std::size_t vertices = 0;
    double spacing = 0;       // mean distance of neighbors, units
    std::size_t classes = 0;  // of vertices that are corrected at once
    // Least over the exemplars corrected at this level; 1 without any.
    double retained_variance = 1;
  };
  std::vector<Level> levels;  // from the finest
  std::size_t welded_vertices = 0;
  // Whose frame turns by more than 30° to a neighbor's, beyond the turns of the field: singularities, where
  // no texture continues.
  std::size_t twisted_vertices = 0;
  std::vector<double> texel_sizes;  // of each exemplar, units
  SynthesisQuality quality;         // as it was measured
};

struct PatchCoordinates {
  // Of each vertex, in [0, 1): u to the right, v upwards, as texture coordinates of the exemplar. They are not
  // rounded to texels: neighbors that continue each other do so to a fraction of one.
  std::vector<formats::Float2> coordinates;
  SynthesisReport report;
};

// The same bytes for any number of threads. Throws Error(kBadInput) as graphOf() does, and where vertices are
// further apart than half an exemplar, or a field of four folds meets an exemplar that is not square. Linear in
// vertices, beside the analysis of exemplars.
PatchCoordinates synthesize(const SurfaceView& surface, std::span<const Exemplar> exemplars,
                            const SynthesisOptions& options);

// The figures of coordinates that come from anywhere.
SynthesisQuality qualityOf(const SurfaceView& surface, std::span<const Exemplar> exemplars,
                           const SynthesisOptions& options, std::span<const formats::Float2> coordinates);

}  // namespace bakelight::mesomesh
