#include "tools/idmap/frames.h"

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/tensor_writer.h"
#include "tools/idmap/normal_shooting.h"
#include "transport/texture_frames.h"

namespace bakelight::idmap {

using formats::Float4;

PatchFrames patchFrames(const formats::TriangleMesh& mesh, const formats::MesoMesh& meso,
                        const std::vector<std::uint32_t>& triangle_materials, std::size_t neighbors,
                        const std::string& meso_file) {
  if (meso.symmetry != 1)
    throw badInput({meso_file, "symmetry", ""},
                   "its tangents are turned by " + std::to_string(360 / meso.symmetry) +
                       "° between neighbors, so no frame leads from vertex to vertex",
                   "symmetry 1", "make the meso-mesh with symmetry 1");
  std::vector<Shot> shots(mesh.vertexCount());
  for (std::size_t v = 0; v < shots.size(); ++v)
    shots[v] = {.position = mesh.positions[v], .normal = mesh.normals[v], .required = false};
  for (std::size_t t = 0; t < triangle_materials.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) shots[v].material = triangle_materials[t];
  std::vector<std::uint32_t> found(shots.size(), NormalShooting::kNone);
  NormalShooting({meso.mesh, meso.materials}, neighbors).shoot(shots, found);
  PatchFrames frames{std::vector<Float4>(shots.size())};
  for (std::size_t v = 0; v < shots.size(); ++v) {
    if (found[v] == NormalShooting::kNone) ++frames.undetermined;
    frames.tangents[v] = found[v] == NormalShooting::kNone
                             ? transport::anyTangent(mesh.normals[v])
                             : transport::tangentAlong(meso.tangents[found[v]], mesh.normals[v], 1.0F);
  }
  return frames;
}

void writeFrames(const std::filesystem::path& path, const std::vector<Float4>& tangents,
                 const formats::TriangleMesh& mesh) {
  formats::TensorWriter writer(path, {{"tangent", {formats::ElementType::kFloat32, {tangents.size(), 4}}}},
                               {{"mesh_hash", formats::geometryHash(mesh)}});
  writer.append("tangent", std::as_bytes(std::span(tangents)));
  writer.finish();
}

}  // namespace bakelight::idmap
