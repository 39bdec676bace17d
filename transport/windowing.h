// Windows against ringing: band l of a light is scaled by 1 / (1 + λ l²(l+1)²), which minimises squared error
// + λ · squared Laplacian (Sloan 2008, "Stupid Spherical Harmonics Tricks"; Rahman & Ravi).
#pragma once

#include "transport/lights.h"

namespace bakelight::transport {

struct WindowedLight {
  ShLight light;
  double lambda = 0;
  double moved_energy =
      0;  // 1 − ‖windowed‖² / ‖light‖², over bands ≥ 1 and all colours; 0 if there is nothing there
};

WindowedLight window(const ShLight& light, double lambda);
// The least λ for which the luminance reconstructed over the sphere (on a fixed lattice) stays above
// −tolerance × its mean.
WindowedLight windowUntilPositive(const ShLight& light, double tolerance = 0.02);

}  // namespace bakelight::transport
