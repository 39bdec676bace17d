#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/stage/stage.h"
#include "tools/transfer/transfer.h"
#include "tools/transfer/transfer_file.h"
#include "transport/ray_scene.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, transfer_path;
  transfer::TransferSettings settings;
  stage::Tool tool("transfer", "Bakes radiance transfer at the vertices of a mesh.");
  transfer::declare(tool, settings);
  tool.input("mesh", "mesh", mesh_path,
             "PLY mesh with normals, as simplify writes it; its colours are the albedo")
      .output("transfer", "tensors", transfer_path, "safetensors file for pack (docs/FORMATS.md)")
      .executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    const transfer::TransferOptions options = transfer::bakeOptions(settings);
    const formats::TriangleMesh mesh = transfer::readBakeableMesh(mesh_path);
    std::vector<formats::Float3> albedo = mesh.colors;
    // Without bounces a uniform albedo stays outside, and pack is free to choose it.
    if (albedo.empty() && options.transport == transfer::Transport::kInterreflected)
      albedo = {settings.albedo};

    const auto start = std::chrono::steady_clock::now();
    transfer::Transfer baked;
    {
      stage::Progress progress = run.progress("transfer", mesh.vertexCount(), "vertices");
      baked = transfer::bakeTransfer(mesh, albedo, options, progress);
    }
    std::optional<transport::Cpca> cpca;
    if (settings.technique == "glossy" && settings.storage == "cpca") {
      stage::Progress progress = run.progress("cpca", settings.cpca.iterations, "rounds");
      cpca = transport::clusteredPca(baked.matrices, baked.matrices.size() / mesh.vertexCount(),
                                     settings.cpca, [&] { progress.advance(); });
    }
    const double bake_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

    transfer::writeTransfer(transfer_path, mesh, settings, albedo, baked, cpca);
    transfer::report(mesh, settings, baked, cpca, bake_s, run);
  });
}
