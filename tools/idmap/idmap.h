// For each texel of an atlas the place in the patch of meso-structure that it shows (Sloan, Liu, Shum & Snyder
// 2003, "Bi-Scale Radiance Transfer", section 4.3).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "formats/index_image.h"
#include "formats/triangle_mesh.h"
#include "tools/idmap/normal_shooting.h"

namespace bakelight::idmap {

using formats::Float2;

// What each vertex of the meso-mesh shows.
struct MesoIndex {
  MesoSurface surface;
  std::span<const Float2> patch;  // in the exemplar of its material, 0–1 (1 not reached), v upwards
};

struct IdMapOptions {
  int neighbors = 20;  // k of the search, ≥ 1
  // By triangle of the mesh that the maps were made of, its material as the meso-mesh numbers them; empty:
  // texels take any.
  std::span<const std::uint32_t> triangle_materials = {};
};

// A patch coordinate is held in so many steps.
inline constexpr double kPatchSteps = 65536;

struct IdMap {
  // Channels:
  //   patch.U, patch.V   coordinate in the patch, in steps of 1/65536 of its side; V upwards
  //   material           of the meso-mesh
  //   vertex             of the meso-mesh that was taken
  //   coverage           as the geometry maps have it; 0: a copy of the nearest texel that has a surface
  formats::IndexImage image;
  ShotFigures figures;
  std::int64_t covered = 0, filled = 0;  // texels
  std::int64_t moved = 0;                // of coverage 3, copied because nothing faces their way
};

// What to warn of where texels lie far from the vertices that they take, compared with the meso-mesh's size: it and
// the maps are hardly of one surface, such as where one was turned. "" if nothing is wrong.
std::string warningOf(const IdMap& map, const formats::TriangleMesh& meso);

// Of an image, for progress. Throws Error(kBadInput) as makeIdMap does.
std::size_t rowsOf(const std::filesystem::path& maps);

// `maps`: the geometry maps that atlas wrote; read by blocks of rows, so that memory is that of the result and
// 9 bytes a texel more. Throws Error(kBadInput) naming file and texel: channels that are missing, a
// texel of the surface that no meso-vertex faces, a triangle beyond the materials, nothing covered.
// `progress` is told of rows that are done. Cost: one search of the k nearest a texel; threads by TBB, same
// bytes for any number.
IdMap makeIdMap(const MesoIndex& meso, const std::filesystem::path& maps, const IdMapOptions& options,
                const std::function<void(std::size_t rows)>& progress);

}  // namespace bakelight::idmap
