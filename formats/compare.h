// How far two files of the same kind are apart, for golden tests and baselines. What must agree exactly
// (counts, names, types) and what may differ within a limit is fixed per kind; the limits are the caller's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/btf.h"
#include "formats/image.h"
#include "formats/index_image.h"
#include "formats/json.h"
#include "formats/meso_mesh.h"
#include "formats/pack.h"
#include "formats/radiance_transfer_texture.h"
#include "formats/tensors.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Largest differences that still pass, inclusive; 0 asks for equal values. A kind looks at its own ones only.
struct CompareLimits {
  // Meshes and packs: symmetric Hausdorff distance between the two sets of vertices, and between the two sets
  // of triangle centroids, over the reference's bounding-box diagonal.
  double distance = 0;
  // Meshes and packs: largest length of the difference of two normals (of vertices nearest to each other).
  double normal = 0;
  // Images (per channel), tensors, radiance transfer textures, BTFs, the tables of packs, texture coordinates and colours of meshes (vertex by
  // vertex): largest absolute difference of two values.
  double maximum = 0;
  // Images, per channel: root of the mean squared difference.
  double rms = 0;
  // Tensors, radiance transfer textures, BTFs and the tables of packs: norm of the difference over the reference's norm. JSON: |a − b| over
  // the larger magnitude, for numbers with a fraction; integers agree exactly.
  double relative = 0;
  // Images of indices, per channel: share of the values that are another.
  double share = 0;
  // JSON members and metadata keys of tensors that are left out, by name, at any depth.
  std::vector<std::string> ignored_keys = {};
};

// One measured difference and its limit.
struct Difference {
  std::string what;  // "channel R, maximum"
  double measured = 0, limit = 0;

  bool passes() const { return measured <= limit; }  // NaN does not pass
};

struct Comparison {
  std::uint64_t compared_values = 0;
  std::vector<Difference> differences;
  std::vector<std::string> mismatches;  // what had to agree exactly: "vertices: 12, the reference has 13"

  // False if nothing was compared.
  bool passes() const;
};

// `reference` is what relative figures refer to; symmetric otherwise.
Comparison compareMeshes(const TriangleMesh& mesh, const TriangleMesh& reference,
                         const CompareLimits& limits);
// Tangents and places on the exemplar vertex by vertex, `maximum`; materials and symmetry exactly.
Comparison compareMesoMeshes(const MesoMesh& meso_mesh, const MesoMesh& reference,
                             const CompareLimits& limits);
Comparison compareImages(const Image& image, const Image& reference, const CompareLimits& limits);
Comparison compareIndices(const IndexImage& image, const IndexImage& reference, const CompareLimits& limits);
// Materials, orders, views and sizes exactly; of each texture `relative` and `maximum`.
Comparison compareRadianceTransferTextures(std::span<const RadianceTransferTexture> textures,
                                           std::span<const RadianceTransferTexture> reference,
                                           const CompareLimits& limits);
// Sizes, directions (to 10⁻⁵ rad), which pictures there are and whether cosines are inside exactly; of all values `relative` and
// `maximum`. Layouts and color models may differ.
Comparison compareBtfs(const Btf& btf, const Btf& reference, const CompareLimits& limits);
Comparison compareTensors(const TensorFile& tensors, const TensorFile& reference,
                          const CompareLimits& limits);
Comparison compareJson(const Json& json, const Json& reference, const CompareLimits& limits);
Comparison comparePacks(const Pack& pack, const Pack& reference, const CompareLimits& limits);

// The kinds that compareFiles knows: "mesh" (our PLY), "meso_mesh", "image", "id_map",
// "rtt", "btf", "tensors", "json", "pack".
const std::vector<std::string>& comparedKinds();

// Packs agree in their sections' names, too: a compressed one is not its plain counterpart. Throws
// Error(kBadInput) if one of the files is missing or damaged; std::invalid_argument for another kind.
Comparison compareFiles(const std::string& kind, const std::filesystem::path& file,
                        const std::filesystem::path& reference, const CompareLimits& limits);

}  // namespace bakelight::formats
