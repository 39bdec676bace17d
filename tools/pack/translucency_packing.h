// What the tool `kernels` baked, as a pack's reflection.
#pragma once

#include <filesystem>
#include <string>

#include "formats/pack_contents.h"
#include "formats/tensors.h"
#include "formats/translucency.h"

namespace bakelight::packing {

// Throws Error(kBadInput) naming file and tensor, as formats::readPart; and if it is of another mesh.
formats::Translucency readTranslucency(const std::filesystem::path& path, const formats::TriangleMesh& mesh);

// Throws Error(kBadInput) naming `kernels_file` for a pack of several materials, and `transfer_file` unless the transfer was baked for what that medium
// lets in ("entered_ior").
void makeTranslucent(formats::Translucency translucency, const std::string& kernels_file,
                     const formats::TensorFile& transfer, const std::string& transfer_file,
                     formats::Pack& pack);

}  // namespace bakelight::packing
