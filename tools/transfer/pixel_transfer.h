// Transfer in a pixel basis: which texels of a cube map of light each vertex sees, sorted by where they stand in the hemisphere
// over it. The local hemisphere's light is then radiance × solid angle that falls on each of its cells, without any filter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "formats/pixel_transfer.h"
#include "formats/triangle_mesh.h"
#include "tools/stage/progress.h"
#include "tools/transfer/surface_points.h"
#include "tools/transfer/trace_phase.h"
#include "transport/ray_scene.h"

namespace bakelight::transfer {

struct PixelOptions {
  int cube_side = 32;                          // texels along an edge of the light's cube map, 1–104
  int local_side = 8;                          // cells along an edge of the hemisphere grid, 1–32
  int subsamples = 2;                          // rays a texel, a side, 1–15
  bool shadows = true;                         // else nothing blocks but the vertex's own horizon
  double bias = 1e-4;                          // as TransferOptions::bias
  std::vector<formats::Float4> tangents = {};  // of the local frames; empty: any tangents
};

struct PixelFigures {
  std::uint64_t rays = 0, blocked_rays = 0;
  std::uint64_t fully_blocked_vertices = 0;
  // Inside another part of the mesh, and how many of them took over what a neighbor sees.
  std::uint64_t buried_vertices = 0, filled_vertices = 0;

  void add(const PixelFigures& other);
};

struct PixelBlock {
  formats::PixelRows rows;
  PixelFigures figures;
};

// Each texel goes, as a whole, to the one cell that its middle is in: cells have equal solid angles and leave no gap, so a row under
// a uniform light holds the light of its cell. (The nearest of the cells' middles, which differs along borders, would share light
// unevenly.) Its code counts the rays, evenly spread over the texel, that rise above the vertex's tangent plane and meet
// nothing. A texel whose middle is below the horizon goes to the cell it is nearest to.
class PixelBaker {
 public:
  // Keeps `mesh` by reference; it has normals. Finds buried vertices: some 64 rays a vertex. Throws std::invalid_argument for options that
  // are out of range.
  PixelBaker(const formats::TriangleMesh& mesh, const PixelOptions& options);
  ~PixelBaker();

  std::size_t vertexCount() const;
  std::span<const formats::Float4> tangents() const;  // of the frames that rows are in

  // The rows of a range of vertices; ranges that follow each other give, appended, those of the whole to the bit. On all TBB threads, the
  // same whatever their number. `progress` advances by one a vertex. Memory: 3 bytes an entry (at most half of the texels a
  // vertex, and a few) and 8 a row. Cost: rays, at most 3 · cube_side² · subsamples² a vertex.
  PixelBlock bake(PointRange range, stage::Progress* progress = nullptr) const;

 private:
  struct Directions;
  struct Workspace;
  void bakeVertex(std::size_t vertex, Workspace& work, PixelBlock& block) const;
  std::uint32_t traceVisible(std::size_t vertex, Workspace& work, std::uint32_t& rays) const;
  void findBuried();
  std::uint32_t cellOf(std::size_t texel, const Eigen::Matrix3d& local_from_object) const;

  const formats::TriangleMesh& mesh_;
  PixelOptions options_;
  std::unique_ptr<const Directions> directions_;
  std::unique_ptr<const transport::RayScene> scene_;  // null without shadows
  std::vector<SurfacePoint> points_;
  std::vector<std::uint8_t> buried_;
  std::vector<std::uint32_t>
      origins_;  // of each vertex, whose point its rays start from: its own unless it is buried
};

// The whole mesh at once.
PixelBlock bakePixelTransfer(const formats::TriangleMesh& mesh, const PixelOptions& options);

}  // namespace bakelight::transfer
