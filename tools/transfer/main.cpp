#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/mesh_ply.h"
#include "formats/tensors.h"
#include "tools/stage/stage.h"
#include "tools/transfer/transfer.h"
#include "tools/transfer/transfer_file.h"
#include "transport/ray_scene.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, transfer_path;
  transfer::DiffuseOptions options;
  std::string visibility = "shadowed";

  stage::Tool tool("transfer", "Bakes diffuse radiance transfer vectors at the vertices of a mesh.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh with normals, as simplify writes it")
      .output("transfer", "tensors", transfer_path,
              "safetensors file with the tensor \"transfer\", vertices × order²")
      .parameter("order", options.order, {1, 10}, "SH bands",
                 "Order of the light that the object will be shown in")
      .parameter("directions", options.directions, {64, 1048576}, "directions over the sphere",
                 "Rays for shadows; each vertex traces the half above its tangent plane")
      .parameter(
          "visibility", visibility, {"shadowed", "unshadowed"},
          "Whether the object shadows itself; unshadowed is exact for convex objects and needs no rays")
      .parameter("bias", options.bias, {0, 0.1}, "of the bounding sphere's radius",
                 "Distance by which rays start off the surface")
      .executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    options.visibility =
        visibility == "shadowed" ? transfer::Visibility::kShadowed : transfer::Visibility::kUnshadowed;
    const formats::TriangleMesh mesh = transfer::readBakeableMesh(mesh_path);

    stage::Progress progress = run.progress("transfer", mesh.vertexCount(), "vertices");
    const auto start = std::chrono::steady_clock::now();
    const transfer::DiffuseTransfer baked = transfer::bakeDiffuse(mesh, options, progress);
    const double bake_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

    formats::writeSafetensors(transfer_path, transfer::tensorFile(mesh, options, visibility, baked));
    transfer::report(mesh, baked, bake_s, run);
  });
}
