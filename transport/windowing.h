// Windows against ringing: band l of a light is scaled by 1 / (1 + λ l²(l+1)²), which minimises squared error
// + λ · squared Laplacian (Sloan 2008, "Stupid Spherical Harmonics Tricks"; Rahman & Ravi).
#pragma once

#include <string>

#include "transport/lights.h"

namespace bakelight::transport {

// What a window of strength λ leaves of band l.
double bandFactor(int l, double lambda);

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

// The least luminance that the coefficients make of the light over the sphere (on a fixed lattice of 8192
// directions), over the mean: below zero where the light rings. 0 for light that is black or darkens on the
// whole.
double minimumOverMean(const ShLight& light);
// What to tell the user of a light with that minimum, after a window of strength `lambda`: nothing unless it
// rings so far below zero that surfaces turn black where they should not.
std::string ringingWarning(double minimum_over_mean, double lambda);

}  // namespace bakelight::transport
