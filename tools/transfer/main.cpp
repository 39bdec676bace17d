#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "formats/material.h"
#include "formats/patch_albedo.h"
#include "formats/tensors.h"
#include "tools/stage/stage.h"
#include "tools/transfer/open_horizon.h"
#include "tools/transfer/pixel_file.h"
#include "tools/transfer/transfer.h"
#include "tools/transfer/transfer_file.h"
#include "transport/ray_scene.h"

using namespace bakelight;

namespace {

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Of the medium that the object consists of; 0 without one.
double enteredIor(const formats::SurfaceMaterials& surface, const std::string& file) {
  double eta = 0;
  for (const std::optional<formats::Medium>& medium : surface.media) {
    const double of_this = medium ? medium->eta : 0;
    if (&medium != &surface.media.front() && of_this != eta)
      throw badInput({file, "", "/medium/eta"}, "materials let different shares of light in",
                     "one index of refraction", "bake such objects apart");
    eta = of_this;
  }
  return eta;
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, original_path, material_path, frames_path, rtt_path, transfer_path;
  transfer::TransferSettings settings;
  stage::Tool tool("transfer", "Bakes radiance transfer at the vertices of a mesh.");
  transfer::declare(tool, settings);
  tool.input(
          "mesh", "mesh", mesh_path,
          "PLY mesh with normals, as simplify writes it; its colours are the albedo unless material has one")
      .input("material", "material", material_path, "what the mesh is made of; light bounces off its albedo",
             {.required = false, .parts = {"albedo", "medium"}})
      .input("frames", "tensors", frames_path,
             "tangents of the vertices' frames, as idmap writes them for a mesh that patches are laid out on",
             false)
      .input("rtt", "rtt", rtt_path,
             "radiance transfer textures of the materials' patches: light bounces off their mean albedo",
             false)
      .input("original", "mesh", original_path,
             "least squares, without bounces: the mesh before simplification, with normals; samples are "
             "taken there",
             false)
      .output("transfer", "tensors", transfer_path, "safetensors file for pack (docs/FORMATS.md)")
      .executionPath(transport::RayScene::executionPath);

  const auto bakePixels = [&](stage::Run& run) {
    transfer::PixelOptions options = transfer::pixelOptions(settings);
    const formats::TriangleMesh mesh = transfer::readBakeableMesh(mesh_path);
    options.tangents = transfer::localFrames(mesh, settings.frames, frames_path, mesh_path.string(), run);
    const auto start = std::chrono::steady_clock::now();
    stage::Progress progress = run.progress("transfer", mesh.vertexCount(), "vertices");
    const auto figures = transfer::writePixelTransfer(transfer_path, mesh, options, progress);
    transfer::report(options, figures, secondsSince(start), run);
  };
  return tool.run(argc, argv, [&](stage::Run& run) {
    if (settings.basis == transfer::Basis::kPixel) return bakePixels(run);
    transfer::TransferOptions options = transfer::bakeOptions(settings);
    const formats::TriangleMesh mesh = transfer::readBakeableMesh(mesh_path);
    formats::TriangleMesh original;
    if (!original_path.empty()) {
      transfer::requireOriginalOfUse(settings, original_path.string());
      original = transfer::readBakeableMesh(original_path);
      options.original = &original;
    }
    if (settings.isGlossy())
      options.tangents = transfer::localFrames(mesh, settings.frames, frames_path, mesh_path.string(), run);
    formats::Materials materials = formats::readMaterialsOrDefault(material_path);
    if (!rtt_path.empty())
      formats::takePatchAlbedo(materials, formats::readRadianceTransferTextures(rtt_path));
    const formats::SurfaceMaterials surface =
        formats::materialsOn(mesh, materials, mesh_path.string(), material_path.string());
    if (surface.replaces_colors) run.warn("the material's albedo stands in place of the mesh's colours");
    std::vector<formats::Float3> albedo = surface.vertex_albedo;
    // Without bounces a uniform albedo stays outside, and pack is free to choose it.
    if (albedo.empty() && options.transport == transfer::Transport::kInterreflected)
      albedo = {surface.albedo};

    settings.options.entered_ior = options.entered_ior = enteredIor(surface, material_path.string());
    if (options.entered_ior > 0 &&
        (options.transport == transfer::Transport::kInterreflected || settings.isGlossy()))
      throw badInput({material_path.string(), "", "/medium"},
                     "it is translucent, and light that bounces between translucent surfaces is not baked",
                     "diffuse transfer without bounces",
                     "set transport shadowed and technique diffuse, as the recipe translucent does");

    const auto start = std::chrono::steady_clock::now();
    transfer::Transfer baked;
    {
      const bool fitted = options.fit == transfer::Fit::kLeastSquares;
      stage::Progress progress = fitted ? run.progress("transfer", mesh.vertexCount() + mesh.triangleCount(),
                                                       "vertices and triangles")
                                        : run.progress("transfer", mesh.vertexCount(), "vertices");
      baked = transfer::bakeTransfer(mesh, albedo, options, progress);
    }
    if (settings.isGlossy() && settings.horizon == transfer::Horizon::kOpen)
      transfer::openHorizons(mesh, options, baked);
    std::optional<transfer::Cpca> cpca;
    if (settings.isGlossy() && settings.storage == transfer::Storage::kCpca) {
      stage::Progress progress = run.progress("cpca", settings.cpca.iterations, "rounds");
      cpca = transfer::clusteredPca(baked.matrices, baked.matrices.size() / mesh.vertexCount(), settings.cpca,
                                    [&] { progress.advance(); });
    }
    const double bake_s = secondsSince(start);

    transfer::writeTransfer(transfer_path, mesh, settings, albedo, baked, cpca);
    transfer::report(mesh, settings, baked, cpca, bake_s, run);
  });
}
