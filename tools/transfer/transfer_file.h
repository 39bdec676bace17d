// How the transfer stage meets the disk: the mesh it accepts, the file it writes, the figures it reports.
#pragma once

#include <filesystem>
#include <string>

#include "formats/tensors.h"
#include "tools/stage/stage.h"
#include "tools/transfer/transfer.h"

namespace bakelight::transfer {

// Throws Error(kBadInput) if the mesh has no vertex or no normals.
formats::TriangleMesh readBakeableMesh(const std::filesystem::path& path);

// Tensor "transfer", F32, vertices × order², with the metadata that pack and inspect read (docs/FORMATS.md).
formats::TensorFile tensorFile(const formats::TriangleMesh& mesh, const DiffuseOptions& options,
                               const std::string& visibility, const DiffuseTransfer& baked);

void report(const formats::TriangleMesh& mesh, const DiffuseTransfer& baked, double bake_s, stage::Run& run);

}  // namespace bakelight::transfer
