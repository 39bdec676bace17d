// From lossless to very small: rows are changed a little, within a bound, so that they share more.
#pragma once

#include <cstdint>

#include "formats/pixel_transfer.h"

namespace bakelight::compression {

// Errors of L*_j under light of at most 1 in all directions, as shares of what its cell of the hemisphere would get under a white
// sky with nothing in the way, 2π / local_side².
struct ToleranceFigures {
  double largest_error = 0;  // over rows, whatever the light: Σ |change of code| · solid angle
  double rms_error = 0;      // over rows, of the same
  double white_sky_error =
      0;  // the largest under a white sky, where changes up and down make up for each other
  double white_sky_rms = 0;
  std::uint64_t changed_rows = 0;
};

struct TolerantRows {
  formats::PixelRows rows;
  ToleranceFigures figures;  // white_sky_* exact, the others at most
};

// No row's error is greater than `tolerance`, 0–1 (std::invalid_argument). First fractions of texels become none or all of the
// texel, then squares of 2 × 2 texels of which a part is seen become unseen or seen as a whole; smallest changes first, within what is
// left of the row's tolerance. On all TBB threads, the same whatever their number. Linear in the entries.
TolerantRows withinTolerance(const formats::PixelCodes& codes, double tolerance);

}  // namespace bakelight::compression
