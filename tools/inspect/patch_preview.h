// Pictures of what shows where in a patch: meso-meshes and id maps.
#pragma once

#include <optional>
#include <string>

#include "formats/image.h"
#include "formats/index_image.h"
#include "formats/meso_mesh.h"
#include "tools/inspect/preview.h"

namespace bakelight::inspect {

// As options.paint has it: colors (auto), patch (place in the patch: red grows with u, green with v), tangents
// (strokes along the field, both ways for symmetry 2, a cross for 4; singularities red where it turns with the
// way around them, blue where against it), coherence (white where neighbors continue each other). Throws
// Error(kBadInput) naming `file` for another paint, colors that it does not have, or no extent.
Preview previewMesoMesh(const formats::MesoMesh& meso, const PreviewOptions& options,
                        const std::string& file);

// Channels patch.U, patch.V, material, vertex, coverage of an EXR.
formats::IndexImage readIdMap(const std::filesystem::path& path);
bool isIdMap(const std::filesystem::path& path);

// In texture space: red grows with u, green with v, a third as bright where copies fill the gutters.
Preview previewIdMap(const formats::IndexImage& ids, const PreviewOptions& options);
// On the model: the same, or colors of `exemplar` (R, G, B, linear) at its places. Throws Error(kBadInput) naming
// `file` if the mesh has no texture coordinates or no extent.
Preview previewThroughIdMap(const formats::TriangleMesh& mesh, const formats::IndexImage& ids,
                            const std::optional<formats::Image>& exemplar, const PreviewOptions& options,
                            const std::string& file);

// Of each vertex the share of its neighbors that continue it in the patch, to half the spacing of vertices, if the
// patch has the width that most neighbors agree on; nothing without two vertices of one material that do.
std::vector<float> coherenceOf(const formats::MesoMesh& meso);

}  // namespace bakelight::inspect
