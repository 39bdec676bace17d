// The hemisphere as a square: the concentric map of Shirley & Chiu 1997 ("A Low Distortion Map Between Disk
// and Square"), lifted from disk to hemisphere with areas kept (r² = 1 − z). All cells of a grid of k × k have
// the solid angle 2π/k².
#pragma once

#include "transport/vector_types.h"

namespace bakelight::transport {

// A unit direction with z ≥ 0 for a point of [0, 1]²; (½, ½) is the zenith, the square's edge the horizon,
// (1, ½) the direction of +x and (½, 1) that of +y.
Vec3 hemisphereFromSquare(double a, double b);

struct SquarePoint {
  double a = 0.5, b = 0.5;
};
// The inverse. `direction` need not be unit; below the horizon it is lifted to it.
SquarePoint squareFromHemisphere(const Vec3& direction);

// The direction at the middle of cell (column, row) of `side` × `side`; rows count with b.
Vec3 hemisphereCell(int side, int column, int row);

// The mean of z over a cell. A grid's mean is exactly ½.
double hemisphereCellCosine(int side, int column, int row);

// The four cells around a direction and their weights, linear in the square. Beyond the middles of the
// outermost cells the nearest are taken (8 × 8: above 76.5° from the zenith). column + 1 and row + 1 exist
// unless side is 1.
struct GridPosition {
  int column = 0, row = 0;
  float across = 0, up = 0;  // 0–1: weights of column + 1 and row + 1
};
GridPosition gridPosition(int side, const Vec3& direction);

}  // namespace bakelight::transport
