// How light goes through a translucent object: kernels of texels and factors between vertices, ready to be packed.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "formats/medium.h"
#include "formats/translucency.h"
#include "tools/kernels/blending.h"
#include "tools/stage/progress.h"

namespace bakelight::kernels {

struct Options {
  Throughput::Options factors = {};
  double kernel_error = 0.002;  // of kernels' principal components, relative; 0: kernels as they are
};

struct Figures {
  std::size_t knots = 0, far_knots = 0, triangles = 0, texels = 0, receivers = 0;
  std::size_t near_entries = 0;
  double texels_per_spacing = 0;     // between knots
  double mean_free_path_texels = 0;  // of the color with the shortest
  double near_dropped_share = 0;
  std::size_t apart_pairs = 0, touching_knots = 0, rank_deficient = 0, clamped = 0;
  std::size_t clamped_reflectances = 0;  // vertices whose color no medium reflects
  double window_share = 0;
  int components = 0;
  double kernel_error = 0;
  std::map<std::string, double> seconds;  // by step: prepare, factors, blend, kernels, compress
};

struct Made {
  formats::Translucency translucency;
  Figures figures;
};

// `mesh` and `maps` are those that atlas wrote, with a border of 4 texels at least; the mesh's colors are what the medium reflects, if that is the albedo. Throws Error(kBadInput) naming file and texel as texelsOf, and for more vertices
// than factors have room for (some 200,000).
Made makeTranslucency(const formats::TriangleMesh& mesh, const std::filesystem::path& maps,
                      const formats::Medium& medium, const Options& options, stage::ProgressStyle progress);

}  // namespace bakelight::kernels
