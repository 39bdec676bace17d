// Light through a plane layer of a scattering medium, by diffusion: what a thick or thin part of an object lets through.
#pragma once

#include "transport/diffusion.h"

namespace bakelight::transport {

// Of what enters one side along the normal, the share that leaves the other is unabsorbed · e^(−attenuation · thickness).
struct SlabTransmission {
  double unabsorbed = 1;   // the share if nothing were absorbed, 0–1
  double attenuation = 0;  // per unit of length; √(3 σa σt′) for a thick layer
};

// Light that is not scattered at all, plus a source at the mean depth at which light is scattered first, between zero fluence 2AD outside of either face (the
// dipole's boundary; Contini, Martelli & Zaccanti 1997, "Photon migration through a turbid slab described by a model based on
// diffusion approximation", with all mirrored sources summed). Where next to nothing is absorbed, within 5 % or so of transport. `thickness` > 0; throws
// std::invalid_argument as DiffuseReflectance.
SlabTransmission slabTransmission(const ScatteringCoefficients& coefficients, double thickness);

}  // namespace bakelight::transport
