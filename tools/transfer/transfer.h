// Radiance self-transfer at the vertices of a mesh (Sloan, Kautz & Snyder 2002, sections 4 and 5; Fujita &
// Kanai 2004, section 3).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "formats/triangle_mesh.h"
#include "tools/stage/progress.h"
#include "tools/transfer/near_field.h"
#include "transport/interreflection.h"

namespace bakelight::transfer {

enum class Transport {
  kUnshadowed,     // closed forms; no rays
  kShadowed,       // other parts of the mesh block light
  kInterreflected  // and send it on, diffusely
};

enum class Glossy {
  kNone,
  kVisibility,  // visibility vectors of order row_order + order − 1; not with interreflection
  kMatrices
};

enum class Fit {
  kVertices,     // transfer at the vertices
  kLeastSquares  // what comes nearest, interpolated, to transfer all over the triangles (transport/vertex_fit.h)
};

struct TransferOptions {
  int order = 5;          // SH bands of the light, 1–10
  int directions = 4096;  // over the whole sphere; each vertex traces the half above its tangent plane
  Transport transport = Transport::kShadowed;
  // Distance by which rays start off the surface, as a share of the bounding sphere's radius. At least a few
  // roundings of the coordinates are kept whatever it says.
  double bias = 1e-4;

  transport::InterreflectionOptions interreflection = {};
  Glossy glossy = Glossy::kNone;
  int row_order = 5;         // SH bands of transferred radiance, 1–10
  Fit fit = Fit::kVertices;  // least squares not with glossy transfer
  int samples = 8;           // least squares: a triangle, each of an eighth of the directions, 256 at least
  // Least squares: what the samples are taken from, a finer mesh with normals, which the one that is baked stands for.
  // None: the latter. Not with bounces.
  const formats::TriangleMesh* original = nullptr;
  // Of the local frames, one a vertex; empty: any tangents (vertexTangents).
  std::vector<formats::Float4> tangents = {};
  // > 0: near-field vectors too, for a virtual sphere of so many radii of the bounding sphere, around its
  // centre. More than 1.
  double sphere_radius = 0;
  // > 0: of what falls on it, what enters a surface of that index of refraction (transport::schlickTransmittance); its vectors are then
  // of that. Of diffuse transfer without bounces.
  double entered_ior = 0;
  // Interreflected: GB (10⁹ bytes) that the bake keeps within, its matrices and visibility vectors apart; 0:
  // defaultMemory (memory_plan.h). Results differ only where exact form factors do not fit.
  double memory = 0;
};

struct FitFigures {
  std::uint64_t samples = 0, rays = 0;
  // Samples that are not looked at: inside of another part of the mesh; with nothing of the original near them that
  // faces the same way.
  std::uint64_t buried_samples = 0, strayed_samples = 0;
  // Vertices whose fitted values would show less than nothing, or more than all, of uniform light: they show that.
  std::uint64_t limited_vertices = 0;
  double least_shown = 1, most_shown = 0;  // of a uniform light of 1, over vertices and colours, before that
  // Of vectors interpolated between vertices, at the samples and over all coefficients: √(Σ area |Δ|² ÷ Σ area |T|²).
  double error_at_vertices = 0, error = 0;
  int iterations = 0;
  double seconds = 0;
};

struct Transfer {
  int channels = 1;  // 3 if coloured surfaces interreflect

  // n vertices × channels × order², row-major: exit radiance of a white Lambertian surface per unit light
  // coefficient,
  //   T_i = 1/π ∫ V(s) max(n·s, 0) y_i(s) ds + what other parts of the surface, of the given albedo, send on.
  std::vector<float> vectors;
  // The same for light on the virtual sphere (near_field.h).
  std::vector<float> near_vectors;
  VirtualSphere sphere;

  // Glossy only. Local frames (surface_points.h), and visibility n × (row_order + order − 1)² in the object's
  // frame or matrices n × channels × row_order² × order² (matrices.h).
  std::vector<formats::Float4> tangents;
  std::vector<float> visibility, matrices;

  std::uint64_t rays = 0, blocked_rays = 0;  // of the shadow pass at the vertices' fronts
  // See no light directly: inside a closed cavity, or buried.
  std::uint64_t fully_blocked_vertices = 0;
  // Inside another part of the mesh (buried.h), and how many of them took over their neighbours' transfer.
  std::uint64_t buried_vertices = 0, filled_vertices = 0;
  // Single vertices that stood out from their neighbours (outliers.h), and how many of them got the mean over
  // their area instead: those that stood out from it, too, as far as kResamplingShare allows.
  std::uint64_t outlying_vertices = 0, resampled_vertices = 0;
  // Largest |quadrature − closed form| of an unshadowed coefficient over the vertices that see blockers: how
  // far the given number of directions is from resolving the basis. The control variate takes this error out
  // of what is not blocked.
  double quadrature_error = 0;

  FitFigures fit;

  transport::InterreflectionReport interreflection;
  std::uint64_t back_points = 0;   // back sides of vertices whose bounced light was needed
  std::uint64_t inside_hits = 0;   // rays that met the inside of a closed part: dark
  std::uint64_t form_factors = 0;  // non-zeros
  std::uint64_t form_factor_bytes = 0;
  // How the limit was kept (memory_plan.h): bytes, how form factors were held, and in how many parts columns
  // were solved.
  std::uint64_t memory_limit = 0, memory_expected = 0;
  bool exact_shares = true;
  double share_threshold = 0;
  int interreflection_parts = 0;
  double shadow_s = 0, interreflection_s = 0, matrices_s = 0;  // wall-clock seconds by step
};

// The most that area samples of outlying vertices may add to the rays; the worst vertices come first.
inline constexpr double kResamplingShare = 0.05;

// The mesh has unit normals; `albedo` is empty (white), one colour for all, or one a vertex, 0–1, and counts
// for interreflection only. The quadrature is a fixed set of directions with the unshadowed closed form as a
// control variate:
//   T = v A + (1 − v) Q[c y] − Q[blocked c y],  v = the cosine-weighted visible share,
// so a vertex that sees no blocker is exact to rounding, as is one that sees no light. Deterministic whatever
// the threads. Cost: vertices × directions / 2 rays, and as many rows of order² multiply-adds where something
// blocks; interreflection records nearest hits instead and then costs its passes; matrices with
// interreflection trace once more. `progress` advances by one per vertex. Throws std::invalid_argument for
// options that exclude each other.
Transfer bakeTransfer(const formats::TriangleMesh& mesh, std::span<const formats::Float3> albedo,
                      const TransferOptions& options, stage::Progress& progress);

}  // namespace bakelight::transfer
