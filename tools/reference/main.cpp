// reference: the picture of a mesh and its material, path-traced without approximations, with its variance.
#include <algorithm>
#include <filesystem>
#include <utility>

#include "formats/light_rig_file.h"
#include "formats/material.h"
#include "formats/mesh_ply.h"
#include "formats/tensors.h"
#include "tools/reference/patch_surface.h"
#include "tools/reference/reference.h"
#include "tools/stage/frame_options.h"
#include "transport/ray_scene.h"

using namespace bakelight;

int main(int argc, char** argv) {
  std::filesystem::path mesh_path, material_path, brdf_path, environment_path, lights_path, framing_path,
      image_path;
  reference::ReflectionModel model = reference::ReflectionModel::kPhysical;
  reference::Translucency translucency = reference::Translucency::kDiffusion;
  reference::Patches patches = reference::Patches::kGeometry;
  reference::Options options;
  reference::GroundOptions ground_options;
  bool ground = false;

  stage::Tool tool("reference",
                   "Path-traces the picture that the player shows of a mesh and its material: ground truth.");
  tool.input("mesh", "mesh", mesh_path, "PLY mesh with normals, as simplify writes it")
      .input("material", "material", material_path,
             "what it is made of; without it: its colours, or grey, and no glossy reflection", false)
      .input("brdf", "tensors", brdf_path, "with reflection table: file of the brdf tool", false)
      .input("environment", "image", environment_path,
             "lat-long HDR light; without it and lights: a soft key light", false)
      .input("lights", "light_rig", lights_path, "light rig: distant lights and emitters; adds up", false)
      .input("framing", "image", framing_path,
             "a picture of this tool, whose mesh the camera frames in place of this one", false)
      .output("image", "image", image_path,
              "EXR, 32-bit floats: R, G, B, A (linear, premultiplied) and variance.R, .G, .B of the means");
  stage::declareFrame(tool, options.frame);
  tool.parameter("reflection", model, reference::kReflectionModels,
                 "physical: ggx by microfacets; lobe, table, none: as a pack's parameter of that name says")
      .parameter(
          "translucency", translucency, reference::kTranslucencies,
          "how light passes through media: by their diffusion model, or by random walks inside the mesh, "
          "which must be closed")
      .parameter("patches", patches, reference::kPatches,
                 "geometry: materials' patches with a surface stand on their faces as triangles, by texture "
                 "coordinates; none: faces are smooth")
      .parameter("transport", options.paths.transport, reference::kTransports,
                 "interreflected: bounces are diffuse, as in a bake; shadowed and unshadowed: direct light")
      .parameter("bounces", options.paths.bounces, {0, 1000}, "",
                 "most reflections between surfaces; 0 is no limit")
      .parameter("integrator", options.paths.integrator, reference::kIntegrators,
                 "uniform: over the hemisphere, without sampling lights; slow, for checks")
      .parameter("at", options.at, reference::kAts,
                 "vertices: exit radiance at the vertices, interpolated as the player does; least_squares: "
                 "the values there "
                 "that, interpolated, come nearest to it all over the triangles")
      .parameter("ground", ground,
                 "a plane that the object stands on, in its shadow and the light that it reflects; the "
                 "object does not see it")
      .parameter("ground_albedo", ground_options.albedo, {0, 1}, "", "what it reflects, red, green, blue")
      .parameter(
          "ground_reach", ground_options.reach, {0.1, 20}, "",
          "how far beyond the object it has faded out, in radii of the bounding sphere; that of neighborhood")
      .parameter("relative_error", options.effort.relative_error, {0, 1}, "",
                 "stop at this standard error relative to the picture; 0: take exactly samples")
      .parameter("samples", options.effort.samples, {32, 1 << 24}, "",
                 "most samples a pixel, a multiple of 16 (rounded down)")
      .parameter("seed", options.seed, {0, 2147483647}, "", "of all random numbers")
      .executionPath(transport::RayScene::executionPath);

  return tool.run(argc, argv, [&](stage::Run& run) {
    if (ground) options.ground = ground_options;
    std::optional<transport::BoundingSphere> bounds;
    if (!framing_path.empty())
      bounds = reference::boundsFromMetadata(formats::readImageMetadata(framing_path), framing_path.string());
    const formats::LightRig rig = formats::readLights(environment_path, lights_path);
    for (const std::string& note : formats::notesOn(rig)) run.warn(note);
    reference::Surface surface{formats::readPly(mesh_path), {}};
    transport::requireTraceableScale(surface.mesh, mesh_path.string());
    surface.model = model;
    surface.translucency = translucency;
    const formats::Materials materials = formats::readMaterialsOrDefault(material_path);
    surface.material =
        formats::materialsOn(surface.mesh, materials, mesh_path.string(), material_path.string());
    if (!brdf_path.empty()) {
      const formats::TensorFile tables = formats::readSafetensors(brdf_path);
      for (const std::string& name : surface.material.names)
        if (tables.tensors.contains(formats::brdfTensorOf(name)))
          surface.tables[name] = formats::brdfTableFrom(tables, brdf_path.string(), name);
      if (tables.tensors.contains(formats::brdfTensorOf("")))
        surface.tables[""] = formats::brdfTableFrom(tables, brdf_path.string());
    }
    if (patches == reference::Patches::kGeometry && reference::hasPatches(materials)) {
      // Framed as the smooth mesh is, whose picture this is compared with.
      if (!bounds) bounds = transport::boundingSphere(surface.mesh);
      reference::PatchedSurface patched = reference::withPatches(surface, materials, mesh_path.string());
      for (const std::string& note : patched.notes) run.warn(note);
      surface = std::move(patched.surface);
    }
    const reference::Reference result =
        reference::makeReference(surface, rig, options, bounds, run.progressStyle());
    formats::writeExr(image_path, result.picture.image, formats::ExrPrecision::kFloat, result.metadata);
    reference::reportStats(run, result.picture, options);
  });
}
