// The pack stage's figures.
#pragma once

#include "formats/file.h"
#include "formats/material.h"
#include "formats/pack.h"
#include "formats/tensors.h"
#include "tools/stage/stage.h"

namespace bakelight::packing {

// `pack` was assembled from `transfer` and written as `bytes` to `file`. Warns if it reflects more light than
// it gets.
void report(const formats::Pack& pack, const formats::TensorFile& transfer, std::span<const std::byte> bytes,
            const std::string& file, stage::Run& run);
// Of what the material has and the pack's lobe has not.
void warnOfLobe(const formats::Pack& pack, const formats::SurfaceMaterials& material, stage::Run& run);

}  // namespace bakelight::packing
