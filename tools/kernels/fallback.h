// What an object looks like to viewers that know no kernels.
#pragma once

#include "formats/medium.h"
#include "formats/translucency.h"

namespace bakelight::kernels {

// Four times the volume that the mesh encloses ÷ its area: the mean length of chords through it (Cauchy). In the mesh's unit; 0 for a
// surface that encloses next to nothing.
double meanThickness(const formats::TriangleMesh& mesh);

// Reflectance of a half space of the medium, by its model of diffusion, and transmission through a layer of the mean thickness
// (transport/slab.h). Where that is 0, nothing goes through. Where the mesh's colors are what the medium reflects, of the mean of them.
formats::TranslucencyFallback fallbackOf(const formats::TriangleMesh& mesh, const formats::Medium& medium);

}  // namespace bakelight::kernels
