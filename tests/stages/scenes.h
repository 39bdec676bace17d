// Small meshes made by code, the inputs of golden cases. Only sums, products, quotients and square roots are
// used, which IEEE 754 rounds the same way everywhere, so an input has the same bits on every machine.
#pragma once

#include <string>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::stages {

// A unit sphere with outward normals: an octahedron, each triangle split in four `subdivisions` times.
// 4^(subdivisions + 1) + 2 vertices.
formats::TriangleMesh sphere(int subdivisions);

// The sphere with its radius between 0.75 and 1.25, smooth and without symmetry; no normals.
formats::TriangleMesh bumpySphere(int subdivisions);

// The unit sphere and one of half its radius above it, a quarter apart: each hides some of the sky from the
// other.
formats::TriangleMesh twoSpheres(int subdivisions);

// The lower half of a sphere, seen from inside: it shadows itself, and its border is open.
formats::TriangleMesh bowl(int subdivisions);

// "sphere", "bumpy_sphere", "two_spheres", "bowl"; throws std::invalid_argument for another name.
formats::TriangleMesh makeScene(const std::string& name, int subdivisions);

}  // namespace bakelight::stages
