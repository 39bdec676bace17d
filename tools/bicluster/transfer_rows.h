// Transfer in a pixel basis from the file that transfer writes.
#pragma once

#include <filesystem>

#include "formats/pixel_transfer.h"
#include "formats/tensors.h"

namespace bakelight::bicluster {

struct TransferRows {
  formats::TensorFile file;  // mapped: what the view looks at
  formats::PixelCodes codes;
};

// Throws Error(kBadInput) naming file, tensor and row for what is not transfer in a pixel basis, or does not fit together.
TransferRows readTransferRows(const std::filesystem::path& path);

}  // namespace bakelight::bicluster
