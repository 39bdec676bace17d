// From measured BTFs to radiance transfer textures (Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance Transfer",
// section 4.2): B_i = Σ_k w_k y_i(l_k) I_k over a Gauss–Legendre rule of lights, where I_k is radiance under a
// directional light of unit irradiance normal to itself.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "formats/btf.h"
#include "formats/radiance_transfer_texture.h"

namespace bakelight::btf {

enum class Cosine { kAsFileSays, kInside, kOutside };

struct ProjectionOptions {
  int views = 8;  // a side of the grid of views; 1: the mean over those of 8 × 8
  int order = 5;
  // Of the quadrature: by cosine of the polar angle, and around.
  int polar_lights = 8, azimuthal_lights = 16;
  double scale = 1;  // of all values: makes them reflectance per steradian
  Cosine cosine = Cosine::kAsFileSays;
  bool clockwise = false;  // azimuths run from the pictures' right towards their bottom
};

struct ProjectionFigures {
  // Of a quarter or more of the pairs of directions have no picture, views and lights are interpolated together.
  bool is_joint = false;
  int views_left_out =
      0;  // for they have pictures under less than half of the lights; never where it is joint
  double view_gap_deg = 0, light_gap_deg = 0;  // from any direction of the hemisphere to the nearest measured
  // Under a uniform sky of 1, the mean over texels and views; by reciprocity the albedo. And the largest of a view's mean.
  std::array<double, 3> mean_radiance = {};
  double largest_view_radiance = 0;
  // √(Σ (B − mean over views of B)² / Σ B²), over all coefficients, colours, texels and views.
  double view_dependence = 0;
};

struct Projected {
  formats::RadianceTransferTexture texture;
  ProjectionFigures figures;
};

// What is interpolated between lights and between views is the reflectance, without the cosine of light, which varies
// less; below 3° above the horizon the cosine is taken to be that of 3°. Where views × lights have
// no more than a quarter of gaps: between the views, of each between the lights it has. Else (CUReT) between pairs: linear
// least squares around each pair of directions, weighted by Gaussians of the distance in both, which returns
// constants exactly. `advance` is called after each view. Decodes each picture once, holds one view's and the
// texture; the same on any number of threads. Throws as decoding does.
Projected project(const formats::Btf& btf, const ProjectionOptions& options,
                  const std::function<void()>& advance = {});

// As project(), but by the cells of a grid of lights × lights over the hemisphere in place of spherical harmonics: the mean over the cell of radiance
// under a directional light of unit irradiance normal to itself, as formats/btf_table.h has it. `order` and its quadrature do not count; of each cell
// light_samples² directions do.
struct GridLights {
  int lights = 8, light_samples = 2;
};
std::vector<float> resample(const formats::Btf& btf, const ProjectionOptions& options, const GridLights& grid,
                            const std::function<void()>& advance = {});

}  // namespace bakelight::btf
