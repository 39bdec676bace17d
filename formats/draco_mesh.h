// A triangle mesh as a Draco bitstream, for KHR_draco_mesh_compression. Private to formats/pack*.cpp and
// their tests.
//
// Edgebreaker (Rossignac 1999) is used, not the sequential coding: it takes two thirds of the bytes when
// lossless and a third when quantised (docs/FORMATS.md has figures) but reorders vertices, splits
// non-manifold ones, and drops isolated vertices and degenerate triangles. So the encoder decodes its own
// result and hands back which source vertex each decoded vertex is.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/file.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Draco's unique ids of the attributes; -1 where there is none.
struct DracoAttributes {
  int position = -1, normal = -1, texcoord = -1;
};

struct DracoMesh {
  Bytes bytes;
  DracoAttributes attributes;
  TriangleMesh decoded;                            // what a reader of `bytes` gets, bit for bit
  std::vector<std::uint32_t> source_from_decoded;  // one entry a decoded vertex
};

// Bits as in PackOptions. Throws Error(kBadInput) naming `file` if Draco cannot carry the mesh: no triangle
// with three different corners, or a result that is not the same surface.
DracoMesh encodeDraco(const TriangleMesh& mesh, int position_bits, int normal_bits, const std::string& file);

// Throws Error(kBadInput) naming `file`.
TriangleMesh decodeDraco(std::span<const std::byte> bytes, const DracoAttributes& attributes,
                         const std::string& file);

}  // namespace bakelight::formats
