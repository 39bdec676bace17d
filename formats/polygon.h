// Polygons of mesh files as triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Keeps its working memory from one polygon to the next.
class PolygonTriangulator {
 public:
  // Appends n − 2 triangles of the polygon's corners (numbers from 0; n >= 3), in its sense of rotation. It
  // may be concave; it is judged in its mean plane (Newell). Corners within an edge belong to triangles of
  // area, so that no crack opens there. False if the polygon has no area or crosses itself: then the
  // triangles name every corner, and that is all.
  //
  // Ear clipping (Meisters 1975, "Polygons have ears"), every other corner in turn, so that a round polygon
  // becomes no fan. Cost: O(n²), near n log n where ears are small.
  bool triangulate(std::span<const Float3> corners, std::vector<Triangle>& triangles);

 private:
  using Point = std::array<double, 2>;

  bool splitQuad(std::span<const Float3> corners, std::vector<Triangle>& triangles) const;
  void start();
  double turnAt(std::uint32_t corner) const;
  bool isEar(std::uint32_t corner) const;
  void clip(std::uint32_t corner, std::vector<Triangle>& triangles);
  void enqueueAll();

  std::vector<Point> points_;                   // the corners in their plane, counter-clockwise
  std::vector<std::uint32_t> previous_, next_;  // of the corners that are left
  std::vector<std::uint32_t> entries_;  // how often a corner was enqueued: only its latest entry counts
  std::vector<char> obstacle_;          // left, and reflex or straight: may lie in others' ears
  std::vector<std::uint32_t> obstacles_by_x_;        // those of the start
  std::vector<std::array<std::uint32_t, 2>> queue_;  // corner, entry
  std::size_t queue_begin_ = 0;
  std::uint32_t remaining_ = 0, some_corner_ = 0;
};

}  // namespace bakelight::formats
