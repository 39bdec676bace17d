// Every exemplar as one level of the surface needs it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tools/mesomesh/synthesis/level_plan.h"
#include "tools/mesomesh/synthesis/matching.h"

namespace bakelight::mesomesh {

// What an exemplar is to the whole surface.
struct PlacedExemplar {
  const Exemplar* exemplar = nullptr;
  double texel_size = 0;  // units
  ExemplarTurns turns;
};

// Throws Error(kBadInput) for an exemplar that does not suit the field or the mesh.
std::vector<PlacedExemplar> placed(std::span<const Exemplar> exemplars, FieldFolds folds,
                                   double vertex_spacing);

// A level is of use to an exemplar while it has three of its vertices across, and its vertices are not so close that
// four fall on a texel.
bool suits(const PlacedExemplar& placed, double vertex_spacing, bool finest);

class LevelAppearance {
 public:
  LevelAppearance(std::span<const PlacedExemplar> exemplars, double vertex_spacing, bool finest, int similar);

  std::span<const ExemplarScale> scales() const { return scales_; }
  std::span<const Matcher* const> matchers() const { return matchers_; }
  double leastRetainedVariance() const;
  bool empty() const;

 private:
  struct Entry {
    AppearanceLevel appearance;
    Matcher matcher;
    Entry(const PlacedExemplar& placed, double step, int similar, bool finest)
        : appearance(*placed.exemplar, step, similar, finest), matcher(appearance, placed.turns) {}
  };
  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<ExemplarScale> scales_;
  std::vector<const Matcher*> matchers_;
};

}  // namespace bakelight::mesomesh
