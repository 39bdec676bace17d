// Transfer in a pixel basis as a file, written as it is baked: memory does not grow with the mesh.
#pragma once

#include <filesystem>

#include "tools/stage/stage.h"
#include "tools/transfer/pixel_transfer.h"
#include "tools/transfer/transfer_file.h"

namespace bakelight::transfer {

struct PixelFileFigures : PixelFigures {
  std::uint64_t vertices = 0, entries = 0;
};

// Tensors codes, columns and row_offsets (compressed sparse rows), normals and tangents. Throws Error(kCannotWrite).
PixelFileFigures writePixelTransfer(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                                    const PixelOptions& options, stage::Progress& progress);

// Throws Error(kBadInput) at a JSON pointer for settings that this basis has not.
PixelOptions pixelOptions(const TransferSettings& settings);

void report(const PixelOptions& options, const PixelFileFigures& figures, double bake_s, stage::Run& run);

}  // namespace bakelight::transfer
