// What a pack holds, as plain data: the mesh, its albedo and its radiance transfer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// How the transfer matrices of a glossy pack are stored (Sloan et al. 2002, section 5; Sloan et al. 2003b).
enum class MatrixStorage {
  kNone,        // a diffuse pack
  kMatrix,      // one matrix a vertex
  kVisibility,  // visibility as an SH vector of order rows + columns − 1; the triple product is taken at run
                // time
  kCpca  // clustered principal components: cluster mean + Σ_k weights[k] · basis[k]
};
const char* nameOf(MatrixStorage storage);  // "none", "matrix", "visibility", "cpca"

// What turns transferred incident radiance into light towards the eye; added to the diffuse part.
enum class LobeModel {
  kNone,
  kPhong,  // normalised cos^exponent around the reflection direction
  kGgx,    // normalised GGX lobe around the reflection direction, alpha = roughness²
  kTable   // any isotropic BRDF, projected (transport/glossy.h)
};
const char* nameOf(LobeModel model);  // "none", "phong", "ggx", "table"

// BRDF × clamped cosine of the incident direction, projected into SH of the local frame with the eye at
// azimuth 0 (in the +x, z half plane). Row a: the eye at cos θ = a / (angles − 1).
struct BrdfTable {
  int angles = 0, order = 0;
  std::vector<float> values;  // angles × 3 (RGB) × order²; coefficients with m < 0 are zero (isotropy)
};

struct GlossyMaterial {
  LobeModel model = LobeModel::kNone;
  float exponent = 0;                 // kPhong, ≥ 0
  float roughness = 0;                // kGgx, 0–1
  Float3 specular_color = {1, 1, 1};  // kPhong, kGgx: reflectance of the lobe, 0–1
  BrdfTable table;                    // kTable; its order is at least row_order
};

// SH index l(l+1)+m throughout; `order` is that of the light. `channels` is 1, or 3 where interreflection was
// coloured: then each table holds red, green and blue one after the other within a row.
struct RadianceTransfer {
  int order = 0;                       // bands of the incident light, 1–10
  std::string transport = "shadowed";  // "unshadowed", "shadowed" or "interreflected"
  int channels = 1;

  // Diffuse vectors (Sloan et al. 2002, eq. 10), object frame: n × (channels · order²). Exit radiance of a
  // vertex = albedo × Σ_i vectors[i] · light[i]: 1/π is inside, the vertex's own albedo is not.
  EncodedTable vectors;
  // The same for light on the virtual sphere (Fujita & Kanai 2004): light[i] are coefficients of what is seen
  // from `sphere_center`. Empty without near field.
  EncodedTable near_vectors;
  Float3 sphere_center = {0, 0, 0};
  float sphere_radius = 0;

  // Glossy: transferred incident radiance in the local frame, row_order² coefficients = matrix · light.
  // The frame is tangents[v].xyz, bitangent = tangents[v].w · cross(normal, tangent), normal as local x, y,
  // z.
  MatrixStorage storage = MatrixStorage::kNone;
  int row_order = 0;
  std::vector<Float4> tangents;
  // kMatrix: n × (channels · row_order² · order²), matrices row-major.
  // kVisibility: n × (row_order + order − 1)², object frame (channels must be 1).
  // kCpca: n × weights a vertex.
  EncodedTable matrices;
  // kCpca: the cluster of each vertex, and (clusters · (1 + weights a vertex)) × (channels · row_order² ·
  // order²) matrices: of each cluster its mean, then its basis.
  std::vector<std::uint32_t> clusters;
  EncodedTable basis;
  GlossyMaterial material;
};

struct Pack {
  std::string name;               // of the asset
  TriangleMesh mesh;              // with normals; its own colours are not written
  Float3 base_color = {1, 1, 1};  // diffuse albedo, linear, 0–1; multiplied by `colors` where there are any
  std::vector<Float3> colors;     // empty, or an albedo a vertex, linear, 0–1
  RadianceTransfer transfer;
};

}  // namespace bakelight::formats
