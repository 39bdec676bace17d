// Packs made by code: closed shapes with the closed-form transfer of unshadowed diffuse surfaces, A_l y_lm(N)
// / π.
#pragma once

#include "formats/pack.h"

namespace bakelight::tests {

// Unit sphere around the origin, `rings` × 2·rings quads, order 1–10.
formats::Pack spherePack(int order, int rings);

// A wavy ball of radius about 1, off the origin, with a small ball in front of it, at +X +Z: creases, hidden
// surfaces, depth jumps. `rings` as above.
formats::Pack wavyPack(int order, int rings);

}  // namespace bakelight::tests
