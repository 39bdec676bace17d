// Packs made by code, with closed-form transfer.
#pragma once

#include "formats/pack.h"
#include "tests/support/pack_parts.h"

namespace bakelight::tests {

// Unit sphere around the origin, `rings` × 2·rings quads, order 1–10. Diffuse transfer of unshadowed
// surfaces: A_l y_lm(N) / π.
formats::Pack spherePack(int order, int rings);

// A wavy ball of radius about 1, off the origin, with a small ball in front of it, at +X +Z: creases, hidden
// surfaces, depth jumps. `rings` and transfer as above.
formats::Pack wavyPack(int order, int rings);

// Makes the pack glossy: matrices of the open hemisphere above each vertex (visibility is the indicator
// function of the hemisphere), tinted a channel if `channels` is 3. Every third frame is left-handed. kCpca
// holds no such matrices but made-up clusters, weights and bases. The material is the caller's.
void addGlossyTransfer(formats::Pack& pack, int row_order, formats::Storage storage, int channels = 1);

// All tables at another precision.
void encodeAt(formats::Precision precision, formats::Pack& pack);

// A BRDF table of made-up values that is isotropic: no coefficients with m < 0.
formats::BrdfTable madeBrdfTable(int angles, int order);

// Near transfer of an unshadowed diffuse body (Fujita & Kanai 2004), by direct quadrature over the virtual
// sphere of `radius` around the origin, which encloses the mesh.
void addNearTransfer(formats::Pack& pack, float radius);

// All vertex positions times `factor`.
void scaleMesh(formats::Pack& pack, float factor);

}  // namespace bakelight::tests
