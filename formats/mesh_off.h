// OFF files (Geomview's Object File Format), text and binary. Private to the importers.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "formats/mesh_parts.h"

namespace bakelight::formats {

// One part; vertices keep the file's order, and are followed by copies where colours of faces meet. Colours
// are display codes (sRGB), as integers to 255 or as numbers to 1. docs/FORMATS.md says which headers are
// read. Throws Error(kBadInput) naming `file` and vertex or face (from 0), in a text with its line. Cost:
// linear.
MeshParts readOff(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::formats
