// A translucent object as it is played: how light that enters its surface comes out of it, in two branches (Lensch, Goesele,
// Bekaert, Kautz, Magnor, Lang & Seidel 2002, "Interactive Rendering of Translucent Objects"). Near by, a kernel of 7 × 7
// texels of an atlas; farther off, factors between the vertices of the mesh, as a product of sparse matrices.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/fields.h"

namespace bakelight::formats {

// A matrix by its rows: row r has the entries [ends[r − 1], ends[r]).
struct SparseRows {
  IntegerArray ends = {4, {}}, columns = {4, {}};  // of 4 bytes
  EncodedTable values;                             // entries × 1, or × 3: red, green and blue

  std::size_t rows() const { return ends.count(); }
  std::span<const std::uint32_t> endsOf() const;
  std::span<const std::uint32_t> columnsOf() const;
  void describe(FieldVisitor& fields, const char* name, std::size_t value_columns, std::size_t end_column);
};

inline constexpr int kKernelSide = 7;
inline constexpr int kKernelTexels = kKernelSide * kKernelSide;

// What stands for the object where this part is not known: in glTF viewers, by KHR_materials_diffuse_transmission, KHR_materials_volume and
// KHR_materials_ior.
struct TranslucencyFallback {
  Float3 reflectance = {1, 1, 1};  // of what enters a half space, what leaves it again, 0–1
  // Through a layer as thick as the object is in the mean goes transmission · color · e^(−attenuation · thickness) of what enters, 0–1.
  float transmission = 0;
  Float3 transmission_color = {1, 1, 1};
  Float3 attenuation = {0, 0, 0};  // in 1 / the asset's unit
  float thickness = 0;             // in the asset's unit; 0: a surface around no volume
};

// Let E be what falls on a texel times what the surface lets in, and B the radiosity of what comes out below the surface. With
//   e = Σ over texels of weights · area · E, and d = Σ blend · E    at knots
//   g = sharpen (near + spread far spreadᵀ) sharpenᵀ e + d
// a texel has B = Σ kernel · E over the texels around it + Σ weights · g of its knots. Knots are the places of the mesh's vertices.
// Areas are in units of `area_unit`, and the matrices times it, so that no numbers depend on the mesh's unit.
struct Translucency {
  static constexpr const char* kKind = "translucency";
  void describe(FieldVisitor& fields);

  int resolution = 0;   // texels of the atlas's side; rows from the top
  float eta = 1;        // index of refraction
  float area_unit = 1;  // in the asset's unit squared
  TranslucencyFallback fallback;
  int knot_count = 0;
  std::vector<std::uint32_t> knots;  // of each vertex of the mesh

  // Texels on which light falls, ascending: row · resolution + column. Those beyond the edge of a chart are of
  // another one, too, and have neither area nor blend.
  IntegerArray texels = {4, {}};       // of 4 bytes
  IntegerArray texel_knots = {4, {}};  // 3 a texel, of 4 bytes
  EncodedTable texel_weights;          // texels × 2: of the second and third knot
  EncodedTable areas;                  // texels × 1
  EncodedTable blend;                  // texels × 9: of each knot red, green and blue

  // Of those which ones light leaves: indices of texels, ascending, each with its kernel: Σ weights · basis, or that itself where
  // there is no basis. A kernel has 7 rows from the top of 7 texels, red, green and blue of each. What lies outside of `texels` has nothing.
  IntegerArray receivers = {4, {}};  // of 4 bytes
  int components = 0;                // of the basis; 0: none
  EncodedTable kernels;              // receivers × components, or × 147
  std::vector<float> basis;          // components × 147

  SparseRows sharpen;  // knots × knots, one value
  SparseRows near;     // knots × knots
  int far_count = 0;   // 0: light does not come that far
  SparseRows spread;   // knots × far knots, one value
  SparseRows far;      // far knots × far knots

  std::size_t texelCount() const { return texels.count(); }
  std::size_t receiverCount() const { return receivers.count(); }
  std::size_t bytes() const;  // of all tables
};

IntegerArray integersOf(std::span<const std::uint32_t> values);
std::span<const std::uint32_t> wordsOf(const IntegerArray& integers);  // of 4 bytes

}  // namespace bakelight::formats
