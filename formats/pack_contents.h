// What a pack holds, as plain data: the mesh, its radiance transfer, and what its materials make of it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/pack_part.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"

namespace bakelight::formats {

inline constexpr int kMaxOrder = 10;  // bands of spherical harmonics

// ---- radiance transfer: what turns light into incident light

enum class Transport { kUnshadowed, kShadowed, kInterreflected };
inline constexpr Word<Transport> kTransports[] = {{"unshadowed", Transport::kUnshadowed},
                                                  {"shadowed", Transport::kShadowed},
                                                  {"interreflected", Transport::kInterreflected}};
constexpr const char* nameOf(Transport transport) {
  return wordFor(kTransports, transport);
}

// Transfer of light on a virtual sphere (Fujita & Kanai 2004): light[i] are coefficients of what is seen from
// `center`.
struct NearField {
  Float3 center = {0, 0, 0};
  float radius = 0;
  EncodedTable vectors;  // n × (channels · order²)
};

// Representations of transfer matrices (Sloan et al. 2002, section 5; Sloan et al. 2003b).
struct MatrixOperator {
  EncodedTable matrices;  // n × (channels · output_order² · order²), row-major
};
struct VisibilityOperator {
  EncodedTable visibility;  // n × (output_order + order − 1)²: visibility as an SH vector in the object's
                            // frame; the triple product is taken at run time, 1 channel
};
// Clustered principal components: matrix = mean of the cluster + Σ_k weights[k] · basis[k].
struct ClusteredOperator {
  EncodedTable weights;                 // n × weights a vertex
  std::vector<std::uint32_t> clusters;  // of each vertex
  // (clusters · (1 + weights a vertex)) × (channels · output_order² · order²): of each its mean, then its
  // basis.
  EncodedTable basis;
};
using Operator = std::variant<MatrixOperator, VisibilityOperator, ClusteredOperator>;
// "matrix", "visibility", "cpca", in the order of the alternatives.
inline constexpr std::array<const char*, 3> kOperatorNames = {"matrix", "visibility", "cpca"};

// Transferred incident radiance, output_order² coefficients = operator · light, in the frame of each vertex:
// tangents[v].xyz, bitangent = tangents[v].w · cross(normal, tangent), normal as local x, y, z; in the
// object's frame for visibility.
struct GlossyTransfer {
  int output_order = 0;
  std::vector<Float4> tangents;
  Operator transfer;

  const char* operatorName() const { return kOperatorNames[transfer.index()]; }
  bool isInObjectFrame() const { return std::holds_alternative<VisibilityOperator>(transfer); }
  // Matrices, visibility or weights: one row a vertex.
  const EncodedTable& vertexTable() const;
  EncodedTable& vertexTable();
};

// Transfer of distant light in spherical harmonics, index l(l+1)+m.
struct ShTransfer {
  static constexpr const char* kKind = "sh";
  void describe(FieldVisitor& fields);

  int order = 0;  // bands of the incident light, 1–10
  Transport transport = Transport::kShadowed;
  int channels = 1;  // or 3 where interreflection was coloured: red, green and blue one after the other in
                     // each row of a table
  // Diffuse vectors (Sloan et al. 2002, eq. 10), object frame: n × (channels · order²). Exit radiance of a
  // vertex = albedo × Σ_i vectors[i] · light[i]: 1/π is inside, the vertex's own albedo is not.
  EncodedTable vectors;
  std::optional<NearField> near_field;
  std::optional<GlossyTransfer> glossy;
};

// ---- reflection: what turns incident light into light towards the eye, beside the diffuse part

struct LambertReflection {
  static constexpr const char* kKind = "lambert";
  void describe(FieldVisitor&) {}
};

// A normalised lobe cos^exponent around the reflection direction.
struct PhongLobe {
  static constexpr const char* kKind = "phong";
  void describe(FieldVisitor& fields);

  float exponent = 0;                 // ≥ 0
  Float3 specular_color = {1, 1, 1};  // reflectance of the lobe, 0–1
};

// A normalised GGX lobe around the reflection direction, alpha = roughness².
struct GgxLobe {
  static constexpr const char* kKind = "ggx";
  void describe(FieldVisitor& fields);

  float roughness = 0;                // 0–1
  Float3 specular_color = {1, 1, 1};  // reflectance of the lobe, 0–1
};

// Any isotropic BRDF × clamped cosine of the incident direction, projected into SH of the local frame with
// the eye at azimuth 0, in the +x, z half plane (transport/glossy.h). Row a: the eye at cos θ = a / (angles −
// 1).
struct BrdfTable {
  static constexpr const char* kKind = "table";
  void describe(FieldVisitor& fields);

  int angles = 0, order = 0;  // order: at least the transfer's output_order
  std::vector<float> values;  // angles × 3 (RGB) × order²; coefficients with m < 0 are zero (isotropy)
};

// A material of the mesh: its name there, its share of the albedo, and its reflection.
struct Appearance {
  std::string material;
  Float3 base_color = {1, 1, 1};  // diffuse albedo, linear, 0–1; multiplied by the pack's colours
  PackPart reflection = LambertReflection{};
};

// ---- the pack

// Kinds of parts that packs are read with. A technique adds its own here, or at the program's start.
PackPartKinds& transferKinds();  // "sh", "pixel"
PackPartKinds&
reflectionKinds();  // "lambert", "phong", "ggx", "table", "radiance_transfer_texture", "btf", "translucency"
PackPartKinds& neighborhoodKinds();  // "neighborhood"

struct Pack {
  std::string name;  // of the asset
  // With normals; its own colours are not written. With several appearances, `triangle_materials` are
  // indices into them, each vertex belongs to one, and vertices are in their order.
  TriangleMesh mesh;
  std::vector<Float3> colors = {};  // empty, or an albedo a vertex, linear, 0–1
  PackPart transfer = ShTransfer{};
  std::vector<Appearance> appearances = {Appearance{}};  // one or more
  std::optional<PackPart> neighborhood = {};             // what the object does to the light around it

  // The transfer, which must be of this kind: else std::invalid_argument.
  const ShTransfer& sh() const;
  ShTransfer& sh();
};

// The vertices of each appearance: [first, end) for each, in order. Throws std::invalid_argument if a vertex
// has two, or vertices are out of order. A vertex without triangle counts with those before it.
struct VertexRange {
  std::size_t first = 0, end = 0;
  std::size_t count() const { return end - first; }
};
std::vector<VertexRange> appearanceRanges(const Pack& pack);

// Row i of whatever there is one a vertex becomes that of vertex source_from_target[i]; so do the mesh's
// positions, normals, texture coordinates and colours, and not its triangles.
void permuteVertices(Pack& pack, std::span<const std::uint32_t> source_from_target);

}  // namespace bakelight::formats
