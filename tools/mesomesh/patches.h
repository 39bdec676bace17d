// The patches of a mesh's materials as exemplars, and what colors they are.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/material.h"
#include "formats/meso_mesh.h"
#include "formats/radiance_transfer_texture.h"
#include "formats/triangle_mesh.h"
#include "tools/mesomesh/synthesis/exemplar.h"
#include "tools/mesomesh/synthesis/synthesize.h"
#include "tools/stage/stage.h"

namespace bakelight::mesomesh {

struct Patches {
  std::vector<Exemplar> exemplars;         // each of another patch; materials without one have a plain texel
  std::vector<formats::Image> colors;      // of each exemplar: R, G, B, linear
  std::vector<std::uint32_t> of_material;  // into `exemplars`; one without names of materials

  // The most folds that all exemplars have (ExemplarSymmetry).
  int folds() const;
};

// Whether any material has a patch.
bool hasPatches(const formats::Materials& materials);

// `material_names`: those of the mesh; empty: one material, the base. Pictures are read as they are stored, so that
// 8-bit ones are compared in sRGB, as eyes do. A patch without a picture is laid out by how it looks: by the texture
// among `transfer` of its material (tools/rtt). Throws Error(kBadInput) naming the picture, as readImage and
// makeExemplar do, and naming `file` for a material of a name that the mesh does not have, or of whose patch there is
// neither picture nor texture.
Patches readPatches(const formats::Materials& materials, const std::vector<std::string>& material_names,
                    const std::string& file, std::span<const formats::RadianceTransferTexture> transfer = {});

// Of each vertex the color of its exemplar at its place: the texel's that it lies in.
std::vector<formats::Float3> colorsAt(const Patches& patches, const std::vector<formats::Float2>& places,
                                      const std::vector<std::uint32_t>& materials);

// Synthesizes places and colors of all vertices, and tells figures and notes to the run.
void layOut(const Patches& patches, const SynthesisOptions& options, const std::string& mesh_file,
            formats::MesoMesh& meso, stage::Run& run);

}  // namespace bakelight::mesomesh
