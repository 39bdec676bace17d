// Which texels a triangle covers: by their centres and by their areas, exactly.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "tools/atlas/charts/surface.h"

namespace bakelight::atlas {

// In texels, from the lower left of the square: texture coordinates times the resolution, which double holds
// exactly. Texel (i, j) is the square [i, i + 1] × [j, j + 1].
using TexelTriangle = std::array<Vec2, 3>;
TexelTriangle texelTriangle(const formats::TriangleMesh& mesh, std::size_t triangle, int resolution);

// Sign of the area, as orientation() in exact.h says it, but quick where rounding is no question.
int orientationOf(const Vec2& a, const Vec2& b, const Vec2& c);

// Rows `begin` … `end` − 1; those that are not in the square count for nothing.
struct RowRange {
  int begin = 0, end = std::numeric_limits<int>::max();
};

// Texels `begin` … `end` − 1 of row `row`; never empty.
struct RowSpan {
  int row, begin, end;
};

// Texels whose centre lies in the triangle, whichever way it turns. A centre on an edge belongs to the
// triangle that has it as its left or its top one: so triangles that share edges claim each centre once, and
// miss none. Rows ascend. Nothing for a triangle without area or with a coordinate that is not finite. Texels
// outside the square are left out. Cost: rows.
void centerSpans(const TexelTriangle& triangle, int resolution, std::vector<RowSpan>& spans,
                 const RowRange& rows = {});

// Texels whose inside the closed triangle meets; so one without area counts, too, unless it lies on the
// lines between texels.
void touchedSpans(const TexelTriangle& triangle, int resolution, std::vector<RowSpan>& spans,
                  const RowRange& rows = {});

}  // namespace bakelight::atlas
