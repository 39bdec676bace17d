// Non-linear wavelet approximation of a transfer matrix's rows (Ng, Ramamoorthi & Hanrahan 2003): of each row's Haar coefficients those
// that matter most are kept, quantised. Light is transformed too, so a product is one of sparse rows.
#pragma once

#include <cstdint>

#include "compression/compressed_transfer.h"
#include "compression/haar.h"

namespace bakelight::compression {

// By |coefficient|, which errs least in the mean square over all light; or by |coefficient| × the solid angle of the wavelet's support, as
// published: large squares of light are brighter than small ones. Over all rows at once, so that rows which need more get more.
enum class Selection { kMagnitude, kAreaWeighted };

// As many coefficients as `budget` bytes hold: lengths of rows, steps between indices, multiples of a quantiser's step, of 5 or 6
// bits, whichever errs least by the selection's own measure. Throws std::invalid_argument if the budget holds none.
CompressedTransfer haarWithin(std::uint64_t budget, const WaveletRows& rows, Selection selection);

}  // namespace bakelight::compression
