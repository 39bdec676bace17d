// The radiance transfer texture of a patch of meso-structure (Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance
// Transfer", section 4.2): what it sends towards each view, of each spherical harmonic of the light on it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "formats/json.h"
#include "formats/radiance_transfer_texture.h"
#include "patch/patch_geometry.h"
#include "tools/rtt/light_directions.h"
#include "tools/rtt/view_dependence.h"
#include "transport/interreflection.h"

namespace bakelight::rtt {

struct Options {
  int resolution = 64;  // texels across; as many down as keeps them square
  // A side of the grid of views. 1: that from straight above stands for all, as it shows each texel what lies at it; a
  // mean over views would show what lies around it, by how deep it is.
  int views = 8;
  int supersampling = 2;  // a side, points a texel
  int order = 5;
  LightRule light_rule = LightRule::kGaussLegendre;
  int polar_lights = 8, azimuth_lights = 16;
  bool shadows = true;
  bool masking = true;
  std::optional<int> bounces = {};  // nothing: all of them
  int bounce_directions = 256;      // over the sphere
  int glossy_samples = 16;          // of each look at a glossy surface
  int elements = 64;                // of the patch's width: longest edge of what light is solved on
};

// Of a run, whatever light is expressed in.
struct Figures {
  std::uint64_t surface_triangles = 0, surface_points = 0;
  double longest_edge = 0;        // of what light was solved on, in widths: as asked for, or longer
  std::uint64_t rays = 0;         // all of them
  std::uint64_t glossy_rays = 0;  // that glossy surfaces mirror
  double hole_share = 0;          // of the rays of all views that meet no surface
  double inside_share = 0;        // of them, that meet the inside of a closed part
  std::uint64_t form_factors = 0, buried_points = 0;
  std::optional<transport::InterreflectionReport> bounced;
  double tree_s = 0, direct_s = 0, seeing_s = 0, solving_s = 0, views_s = 0;  // what took how long
  ViewDependence view_dependence;
  double depth = 0;  // of the surface, in widths of the patch
  // Share of light that the patch reflects under a uniform sky, over all views by their cosines: what a surface
  // that carries it gives back to others.
  formats::Float3 mean_albedo = {};
};

struct Rtt {
  formats::RadianceTransferTexture texture;
  Figures figures;
};

// `progress` is told of views that are done, views² of them.
Rtt makeRtt(const patch::PatchGeometry& geometry, const Options& options,
            const std::function<void()>& progress);

}  // namespace bakelight::rtt
