// What kind of file a path is, by its ending, and by content where an ending has two meanings.
#pragma once

#include <filesystem>

namespace bakelight::inspect {

enum class FileKind { kMesh, kImage, kTensors, kPack, kMaterial, kRecord, kMesoMesh, kIdMap, kBtf, kRtt };

const char* nameOf(
    FileKind
        kind);  // "mesh", "image", "tensors", "pack", "material", "record", "meso_mesh", "id_map", "btf", "rtt"

// Throws Error(kBadInput) that lists what inspect opens, or that the file cannot be read.
FileKind kindOfFile(const std::filesystem::path& path);

}  // namespace bakelight::inspect
