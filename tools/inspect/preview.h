// A picture of what a file holds.
#pragma once

#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"

namespace bakelight::inspect {

enum class Paint {
  kAutomatic,  // charts in the atlas's layout, else none
  kNone,
  kCharts,     // a colour for each chart of the texture coordinates
  kStretch,    // how much texture each triangle has
  kMaterials,  // a colour for each material
  kColors,     // those of the vertices
  // Of meso-meshes (patch_preview.h):
  kPatch,
  kTangents,
  kCoherence,
};
enum class Layout {
  kModel,  // a render
  kAtlas,  // the unit square of the texture coordinates
};
inline constexpr formats::Word<Paint> kPaints[] = {
    {"auto", Paint::kAutomatic},  {"none", Paint::kNone},           {"charts", Paint::kCharts},
    {"stretch", Paint::kStretch}, {"materials", Paint::kMaterials}, {"colors", Paint::kColors},
    {"patch", Paint::kPatch},     {"tangents", Paint::kTangents},   {"coherence", Paint::kCoherence}};
inline constexpr formats::Word<Layout> kLayouts[] = {{"model", Layout::kModel}, {"atlas", Layout::kAtlas}};

struct PreviewOptions {
  int size_px = 512;  // of the longer side; renders are square
  // Of the camera around a mesh or a pack (transport::OrbitCamera).
  double yaw_deg = 25, pitch_deg = 15;
  // Of meshes and packs.
  Paint paint = Paint::kAutomatic;
  Layout layout = Layout::kModel;

  bool showsTexcoords() const {
    return layout == Layout::kAtlas || paint == Paint::kCharts || paint == Paint::kStretch;
  }
};

struct Preview {
  formats::Image image;  // display-encoded, as formats::writePng takes it
  std::string caption;   // what the colours mean
};

// Clay under transport::defaultLight, without shadows; normals of the mesh, or smooth ones if it has
// none. Throws Error(kBadInput) naming `file` if the mesh has no extent.
Preview previewMesh(const formats::TriangleMesh& mesh, const PreviewOptions& options,
                    const std::string& file);

// Colours of the vertices instead of the clay's. Throws Error(kBadInput) naming `file` if it has none, or no
// extent.
Preview previewColors(const formats::TriangleMesh& mesh, const PreviewOptions& options,
                      const std::string& file);

// Charts, stretch or materials, on the clay or in the unit square (u right, v up), whatever `options` ask
// for; dark lines where charts end. Throws Error(kBadInput) naming `file` if the mesh has no texture
// coordinates or no extent.
Preview previewAtlas(const formats::TriangleMesh& mesh, const PreviewOptions& options,
                     const std::string& file);

// A colour for each material on the clay, dark lines where materials end. Throws Error(kBadInput) naming
// `file` if the mesh has no materials or no extent.
Preview previewMaterials(const formats::TriangleMesh& mesh, const PreviewOptions& options,
                         const std::string& file);

// The pack under transport::defaultLight as distant light, glossy part included, as the player shows it.
// Throws like previewMesh.
Preview previewPack(const formats::Pack& pack, const PreviewOptions& options, const std::string& file);

// Colour at an exposure that brings the mean to a middle value, or codes as they stand if `display_encoded`;
// without R, G and B the first channel in grey, scaled from its least to its largest value. Values that are
// not finite are magenta.
Preview previewImage(const formats::Image& image, bool display_encoded, const PreviewOptions& options);

// The tensor "transfer", or else the first table: rows down (averaged where they outnumber the pixels),
// columns (all extents but the first) across, blue below 0, white at 0, red above; dark lines between SH
// bands. Throws Error(kBadInput) naming `file` if there is no table.
Preview previewTensors(const formats::TensorFile& tensors, const PreviewOptions& options,
                       const std::string& file);

}  // namespace bakelight::inspect
