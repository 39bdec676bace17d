// Whether an exemplar looks the same after a quarter or a half turn.
#pragma once

#include "tools/mesomesh/synthesis/exemplar.h"

namespace bakelight::mesomesh {

// Compares 1024 texels, hashed, under every shift (periodic) or about the middle (not periodic), then all
// texels under the best. A quarter turn of an exemplar that is not square has likeness 0.
ExemplarSymmetry measureSymmetry(const Exemplar& exemplar);

}  // namespace bakelight::mesomesh
