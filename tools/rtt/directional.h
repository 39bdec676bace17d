// The bidirectional texture function of a patch of meso-structure: what it sends towards each view, of the light from each
// cell of the hemisphere's grid (Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance Transfer", section 4.2). The same
// surface, light and looks as makeRtt's, in another basis.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "formats/btf.h"
#include "patch/patch_geometry.h"
#include "tools/rtt/rtt.h"

namespace bakelight::rtt {

struct BtfOptions {
  int lights = 8;         // a side of the grid of lights
  int light_samples = 2;  // a side, directions of light in each cell
};

struct DirectionalBtf {
  // Views: the middles of views × views cells; lights: of lights × lights. A value is the mean over the cell of the
  // radiance under a directional light of unit irradiance normal to itself, so cosines are inside: times radiance × solid angle
  // that comes through the cell, summed over the cells, it is the radiance towards the view.
  std::unique_ptr<formats::Btf> btf;
  Figures figures;  // without view_dependence
  // The same: [view][texel][color][light].
  std::shared_ptr<const std::vector<float>> rendered;
  std::span<const float> values() const { return *rendered; }
};

// Bytes of the values in memory, views² · lights² · texels · 12; and of the light on the surface, points · lights² · 12, which
// is held some five times while it is solved.
double btfBytes(const Options& options, const BtfOptions& btf, double aspect);
double lightBytes(const patch::PatchGeometry& geometry, const Options& options, const BtfOptions& btf);

// `file`: what it is called in messages. `progress` as of makeRtt. Memory as above. Threads by
// TBB, same bytes for any number.
DirectionalBtf makeBtf(const patch::PatchGeometry& geometry, const Options& options, const BtfOptions& btf,
                       const std::string& file, const std::function<void()>& progress);

}  // namespace bakelight::rtt
