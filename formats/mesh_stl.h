// STL files, binary and text. Private to the importers.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "formats/mesh_parts.h"

namespace bakelight::formats {

// One part of three vertices a facet, as the format has no shared ones. A file as long as its number of
// facets says is binary, whatever its header says; otherwise one that begins with "solid" is text. Colours of
// facets (VisCAM's and Materialise's use of the two attribute bytes) become those of vertices, sRGB by
// custom. Normals of the file are not read, as the winding says the same; facets where it does not are noted.
// Throws Error(kBadInput) naming `file` and facet (from 0) or line. Cost: linear.
MeshParts readStl(std::span<const std::byte> bytes, const std::string& file);

}  // namespace bakelight::formats
