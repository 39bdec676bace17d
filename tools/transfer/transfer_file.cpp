#include "tools/transfer/transfer_file.h"

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "transport/sh.h"

namespace bakelight::transfer {

formats::TriangleMesh readBakeableMesh(const std::filesystem::path& path) {
  formats::TriangleMesh mesh = formats::readPly(path);
  if (mesh.vertexCount() == 0)
    throw badInput({path.string(), "", ""}, "has no vertex", "a mesh to bake at",
                   "check the stage that wrote it");
  if (mesh.normals.size() != mesh.vertexCount())
    throw badInput({path.string(), "", ""}, "has no normals", "properties nx, ny, nz at each vertex",
                   "run the mesh through simplify, which makes them");
  return mesh;
}

formats::TensorFile tensorFile(const formats::TriangleMesh& mesh, const DiffuseOptions& options,
                               const std::string& visibility, const DiffuseTransfer& baked) {
  const auto count = static_cast<std::uint64_t>(transport::coefficientCount(options.order));
  formats::TensorFile file;
  file.tensors["transfer"] = formats::Tensor::from<float>(formats::ElementType::kFloat32,
                                                          {mesh.vertexCount(), count}, baked.vectors);
  file.metadata = {{"technique", "diffuse_vector"},
                   {"order", std::to_string(options.order)},
                   {"visibility", visibility},
                   {"basis", "real_sh_cartesian"},
                   {"frame", "object"},
                   {"albedo", "outside"},
                   {"inverse_pi", "inside"},
                   {"mesh_hash", formats::geometryHash(mesh)}};
  return file;
}

void report(const formats::TriangleMesh& mesh, const DiffuseTransfer& baked, double bake_s, stage::Run& run) {
  run.stat("vertices", mesh.vertexCount());
  run.stat("bake_s", bake_s);
  run.stat("rays", baked.rays);
  run.stat("rays_per_s", static_cast<double>(baked.rays) / bake_s);
  run.stat("blocked_ray_share",
           baked.rays > 0 ? static_cast<double>(baked.blocked_rays) / static_cast<double>(baked.rays) : 0.0);
  run.stat("fully_blocked_vertices", baked.fully_blocked_vertices);
  run.stat("buried_vertices", baked.buried_vertices);
  run.stat("filled_vertices", baked.filled_vertices);
  run.stat("quadrature_error", baked.quadrature_error);
  if (baked.rays > 0 && baked.blocked_rays == 0)
    run.warn("nothing blocks any ray: visibility \"unshadowed\" gives the same result without rays");
  if (baked.fully_blocked_vertices > mesh.vertexCount() / 2)
    run.warn("most vertices see no light at all: is the mesh closed and turned inside out?");
}

}  // namespace bakelight::transfer
