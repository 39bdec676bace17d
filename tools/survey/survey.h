// What light transport a mesh needs, measured with a few rays before any of it is baked: whether it is
// convex, how much of their surroundings its parts block, how much light bounces between them, and how much
// of what leaves depends on the view.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/material.h"
#include "formats/triangle_mesh.h"

namespace bakelight::survey {

using formats::Float3;

struct SurveyOptions {
  Float3 albedo = {0.8F, 0.8F, 0.8F};                             // diffuse, where the mesh has no colours
  Float3 specular_color = {0.2F, 0.2F, 0.2F};                     // reflectance of the lobe
  enum class Lobe { kNone, kTinted, kTable } lobe = Lobe::kNone;  // kTinted: by the specular colour
  std::vector<Float3> triangle_specular = {};  // kTinted: instead of specular_color, one a triangle; or empty
  int samples = 4096;                          // points on the surface, >= 2
};

// What a survey looks at of the materials of a mesh: the reflectance of a lobe is its specular colour or,
// where that rises towards grazing angles by Fresnel, its mean over a diffuse sky's angles, (1 + 20 ·
// colour)/21 (Schlick's term under the cosine); masking is not taken off. One table makes all of it a table.
SurveyOptions optionsFor(const formats::SurfaceMaterials& materials);

struct Estimate {
  double value = 0;
  double standard_error = 0;  // 0: exact
};

// All means are over the area of the fronts.
struct Survey {
  double concavity = 0;  // survey::concavity
  // Share of its hemisphere, weighted by the cosine, that the mesh blocks from a point of it.
  Estimate blocked_share;
  double largest_blocked_share = 0;  // of the points that were sampled, by kDirections rays each
  // Exit radiance under a uniform white sky with all bounces, over that without, less 1. Bounces are diffuse;
  // luminance.
  Estimate bounce_energy;
  // Share of exit radiance under that sky, all bounces included, that depends on the view: lobe over lobe and
  // diffuse part; luminance. A lobe returns its reflectance times the light that arrives. 1 for a table, of
  // which nothing is known here.
  Estimate view_dependence;
  std::uint64_t rays = 0;
};

// Concavities up to this count as none: no ray is traced then, and nothing is estimated.
inline constexpr double kConvex = 1e-5;
inline constexpr int kDirections = 64;

// The mesh as it is tessellated: directions are about the triangles' own normals, as directions that lie
// above an interpolated normal's plane but below the triangle would be blocked by nothing that is there.
// Points are stratified by area, directions by cosine; a few of the blocked ones go on as random walks. Seeds
// are fixed: the same figures always, whatever the number of threads. Light that meets a triangle from behind
// goes on where that side can be seen (its part has an open border, or another triangle is its back) and is
// lost inside closed parts. Without colours everything reflects `albedo`. Cost: samples × (kDirections + a
// few walks) rays. Throws std::invalid_argument if no triangle has an area, or if samples is below 2.
Survey survey(const formats::TriangleMesh& mesh, const SurveyOptions& options);

}  // namespace bakelight::survey
