// Cells of a grid, drawn by weight.
#pragma once

#include <span>
#include <vector>

namespace bakelight::reference {

// width × height cells, rows one after the other. A row is drawn first, then a cell in it, each by inverting
// cumulative weights, so that strata of the unit square stay together (Pharr, Jakob & Humphreys, "Physically
// Based Rendering", 4th edition, A.5).
class GridDistribution {
 public:
  // No weight is negative.
  GridDistribution(int width, int height, std::span<const double> weights);

  double total() const { return total_; }  // of the weights
  // Of being drawn; all sum up to 1, or are 0 without any weight.
  double probability(int x, int y) const;

  struct Cell {
    int x, y;
    double across, down;  // where in the cell, each in [0, 1) and uniform
  };
  // The image of a point of the unit square. Not to be called if total() is 0.
  Cell draw(double u, double v) const;

 private:
  int width_;
  double total_;
  // Cumulative probabilities: of rows (height + 1), and within each row (height × (width + 1)).
  std::vector<double> rows_, columns_;
};

}  // namespace bakelight::reference
