#include "tools/transfer/transfer_file.h"

#include <nlohmann/json.hpp>

#include "formats/error.h"
#include "formats/mesh_ply.h"
#include "formats/tensor_writer.h"
#include "transport/ray_scene.h"
#include "transport/sh.h"
#include "transport/texture_frames.h"
#include "transport/vector_types.h"

namespace bakelight::transfer {

using formats::ElementType;
using formats::Float3;

namespace {

constexpr formats::Word<Basis> kBases[] = {{"sh", Basis::kSh}, {"pixel", Basis::kPixel}};
constexpr formats::Word<Technique> kTechniques[] = {{"diffuse", Technique::kDiffuse},
                                                    {"glossy", Technique::kGlossy}};
constexpr formats::Word<Storage> kStorages[] = {
    {"matrix", Storage::kMatrix}, {"visibility", Storage::kVisibility}, {"cpca", Storage::kCpca}};
constexpr formats::Word<FrameSource> kFrameSources[] = {{"normals", FrameSource::kNormals},
                                                        {"texcoords", FrameSource::kTexcoords}};
constexpr formats::Word<Horizon> kHorizons[] = {{"cut", Horizon::kCut}, {"open", Horizon::kOpen}};
constexpr formats::Word<Fit> kFits[] = {{"vertices", Fit::kVertices}, {"least_squares", Fit::kLeastSquares}};
constexpr formats::Word<Transport> kTransports[] = {{"unshadowed", Transport::kUnshadowed},
                                                    {"shadowed", Transport::kShadowed},
                                                    {"interreflected", Transport::kInterreflected}};

std::uint64_t squared(int order) {
  return static_cast<std::uint64_t>(transport::coefficientCount(order));
}

// What is to be written, by reference.
class Contents {
 public:
  std::map<std::string, std::string> metadata;

  void add(const std::string& name, std::vector<std::uint64_t> shape, std::span<const float> values) {
    put(name, ElementType::kFloat32, std::move(shape), std::as_bytes(values));
  }
  void add(const std::string& name, std::vector<std::uint64_t> shape, std::span<const std::uint32_t> values) {
    put(name, ElementType::kUint32, std::move(shape), std::as_bytes(values));
  }
  template <std::size_t kSize>
  void addRows(const std::string& name, std::span<const std::array<float, kSize>> rows) {
    put(name, ElementType::kFloat32, {rows.size(), kSize}, std::as_bytes(rows));
  }
  void write(const std::filesystem::path& path) const {
    formats::TensorWriter writer(path, shapes_, metadata);
    for (const auto& [name, bytes] : values_) writer.append(name, bytes);
    writer.finish();
  }

 private:
  void put(const std::string& name, ElementType type, std::vector<std::uint64_t> shape,
           std::span<const std::byte> bytes) {
    shapes_[name] = {type, std::move(shape)};
    values_[name] = bytes;
  }

  std::map<std::string, formats::TensorShape> shapes_;
  std::map<std::string, std::span<const std::byte>> values_;
};

void addGlossy(const TransferSettings& settings, const Transfer& baked, const std::optional<Cpca>& cpca,
               std::uint64_t vertices, Contents& contents) {
  const auto channels = static_cast<std::uint64_t>(baked.channels);
  const std::uint64_t rows = squared(settings.options.row_order), columns = squared(settings.options.order);
  contents.metadata["row_order"] = std::to_string(settings.options.row_order);
  if (settings.horizon == Horizon::kOpen)
    contents.metadata["horizon"] = formats::wordFor(kHorizons, settings.horizon);
  contents.metadata["storage"] = formats::wordFor(kStorages, settings.storage);
  contents.addRows<4>("tangent", baked.tangents);
  if (cpca) {
    const auto components = static_cast<std::uint64_t>(cpca->components);
    contents.add("weights", {vertices, components}, cpca->weights);
    contents.add("cluster", {vertices}, cpca->clusters);
    contents.add("basis", {cpca->cluster_count, 1 + components, channels, rows, columns}, cpca->basis);
  } else if (settings.storage == Storage::kVisibility) {
    contents.add("visibility", {vertices, squared(settings.options.row_order + settings.options.order - 1)},
                 baked.visibility);
  } else {
    contents.add("matrix", {vertices, channels, rows, columns}, baked.matrices);
  }
}

}  // namespace

void declare(stage::Tool& tool, TransferSettings& settings) {
  TransferOptions& options = settings.options;
  tool.parameter(
          "basis", settings.basis, kBases,
          "What light is given in: spherical harmonics, soft light and bounces; or the texels of a cube map, "
          "light and shadows as sharp as these, without bounces")
      .parameter("cube_side", settings.pixel.cube_side, {1, formats::kMostCubeSide}, "texels",
                 "Pixel: along an edge of the light's cube map")
      .parameter("local_side", settings.pixel.local_side, {1, formats::kMostLocalSide}, "cells",
                 "Pixel: along an edge of the grid over a vertex's hemisphere, as its BTF has them")
      .parameter("subsamples", settings.pixel.subsamples, {1, formats::kMostSubsamples}, "rays",
                 "Pixel: a texel, along an edge")
      .parameter("technique", settings.technique, kTechniques,
                 "Transfer vectors only, or transfer matrices too, for glossy reflection at run time")
      .parameter("transport", options.transport, kTransports,
                 "Whether the object shadows itself and light bounces between its parts; unshadowed is exact "
                 "for convex objects and needs no rays")
      .parameter("order", options.order, {1, 10}, "SH bands",
                 "Order of the light that the object will be shown in")
      .parameter("row_order", options.row_order, {1, 10}, "SH bands",
                 "Glossy: order of the transferred radiance that lobes reflect")
      .parameter(
          "storage", settings.storage, kStorages,
          "Glossy: full matrices, visibility vectors (smallest; not with interreflection), or clustered "
          "principal components")
      .parameter("frame", settings.frames, kFrameSources,
                 "Glossy, pixel: whether vertices' frames follow texture coordinates, as patches need it "
                 "that are laid "
                 "out by them, or are any")
      .parameter("horizon", settings.horizon, kHorizons,
                 "Glossy: whether light from below a vertex's own tangent plane is cut off, as lobes need "
                 "it, or passes, "
                 "for radiance transfer textures, which leave it out themselves")
      .parameter("clusters", settings.cpca.clusters, {1, 65536}, "", "cpca: clusters of vertices, at most")
      .parameter("components", settings.cpca.components, {1, 64}, "", "cpca: weights a vertex")
      .parameter("directions", options.directions, {64, 1048576}, "directions over the sphere",
                 "Rays for shadows; each vertex traces the half above its tangent plane")
      .parameter(
          "fit", options.fit, kFits,
          "Transfer as it is at the vertices, or what comes nearest, interpolated, to samples all over the "
          "triangles: less error of the same bytes; not of matrices")
      .parameter("samples", options.samples, {1, 4096}, "a triangle",
                 "Least squares: each takes an eighth of the directions, 256 at least")
      .parameter("threshold", options.interreflection.threshold, {1e-6, 1}, "share of all light",
                 "Interreflected: bounces go on until less than this can be missing")
      .parameter("bounces", options.interreflection.bounces, {0, 1000}, "",
                 "Interreflected: exactly so many bounces; 0 goes by the threshold")
      .parameter(
          "memory", options.memory, {0, 1e6}, "GB",
          "Interreflected: what the bake keeps within, matrices apart, where need be by sums over fewer "
          "shares of what is seen; 0: 2, or as many as million vertices times 2")
      .parameter(
          "near_field", settings.near_field,
          "Vectors for light at a finite distance, on a virtual sphere, beside those for distant light")
      .parameter("sphere_radius", settings.sphere_radius, {1.01, 1000}, "radii of the bounding sphere",
                 "Near field: the virtual sphere, around the object's centre")
      .parameter("bias", options.bias, {0, 0.1}, "of the bounding sphere's radius",
                 "Distance by which rays start off the surface")
      .retired("albedo", R"(a material: in asset.json "material": { "albedo": [0.8, 0.8, 0.8] })");
}

TransferOptions bakeOptions(const TransferSettings& settings) {
  TransferOptions options = settings.options;
  options.sphere_radius = settings.near_field ? settings.sphere_radius : 0;
  if (settings.isGlossy() && options.fit == Fit::kLeastSquares)
    throw badInput({"", "", "/fit"}, "transfer matrices are in the frames of their vertices, and not fitted",
                   "\"vertices\"", "with technique \"diffuse\" it can be kept");
  if (settings.isGlossy()) {
    options.glossy = settings.storage == Storage::kVisibility ? Glossy::kVisibility : Glossy::kMatrices;
    if (options.transport == Transport::kInterreflected && options.glossy == Glossy::kVisibility)
      throw badInput({"", "", "/storage"}, "a visibility vector cannot hold interreflection",
                     "\"matrix\" or \"cpca\"", "with transport \"shadowed\" it can be kept");
  }
  return options;
}

formats::TriangleMesh readBakeableMesh(const std::filesystem::path& path) {
  formats::TriangleMesh mesh = formats::readPly(path);
  if (mesh.vertexCount() == 0)
    throw badInput({path.string(), "", ""}, "has no vertex", "a mesh to bake at",
                   "check the stage that wrote it");
  if (mesh.normals.size() != mesh.vertexCount())
    throw badInput({path.string(), "", ""}, "has no normals", "properties nx, ny, nz at each vertex",
                   "run the mesh through simplify, which makes them");
  transport::requireTraceableScale(mesh, path.string());
  for (std::size_t v = 0; v < mesh.colors.size(); ++v)
    for (const float value : mesh.colors[v])
      if (!(value >= 0 && value <= 1))
        throw badInput({path.string(), "vertex " + std::to_string(v), ""},
                       "its colour is " + std::to_string(value), "a linear albedo of 0 to 1");
  return mesh;
}

void requireOriginalOfUse(const TransferSettings& settings, const std::string& original_file) {
  if (settings.options.fit != Fit::kLeastSquares)
    throw badInput({original_file, "", "/fit"},
                   "samples are taken from the original only where they are fitted", "\"least_squares\"",
                   "leave the original out");
  if (settings.options.transport == Transport::kInterreflected)
    throw badInput({original_file, "", "/transport"}, "light that bounces off the original is not known",
                   "\"shadowed\" or \"unshadowed\"", "leave the original out");
}

std::vector<formats::Float4> localFrames(const formats::TriangleMesh& mesh, FrameSource source,
                                         const std::filesystem::path& frames_path,
                                         const std::string& mesh_file, stage::Run& run) {
  if (!frames_path.empty()) {
    const std::string file = frames_path.string();
    const formats::TensorFile tensors = formats::readSafetensors(frames_path);
    const formats::Tensor& tangents = tensors.require("tangent", ElementType::kFloat32, 2, file);
    if (tensors.requireMetadata("mesh_hash", file) != formats::geometryHash(mesh))
      throw badInput({file, "metadata mesh_hash", ""},
                     "the frames were made for another mesh than " + mesh_file, formats::geometryHash(mesh),
                     "make them again with idmap, for this mesh");
    if (tangents.shape != std::vector<std::uint64_t>{mesh.vertexCount(), 4})
      throw badInput({file, "tensor tangent", ""}, "it has another shape",
                     std::to_string(mesh.vertexCount()) + " × 4");
    const auto values = tangents.as<float>();
    std::vector<formats::Float4> result(mesh.vertexCount());
    for (std::size_t v = 0; v < result.size(); ++v) {
      result[v] = {values[4 * v], values[4 * v + 1], values[4 * v + 2], values[4 * v + 3]};
      const transport::Vec3 tangent(result[v][0], result[v][1], result[v][2]);
      if (!(std::abs(tangent.norm() - 1) < 1e-3 && std::abs(result[v][3]) == 1 &&
            std::abs(tangent.dot(transport::vec3(mesh.normals[v]))) < 1e-3))
        throw badInput({file, "tangent of vertex " + std::to_string(v), ""},
                       "it is no unit vector perpendicular to the normal, with 1 or −1", "a frame");
    }
    return result;
  }
  if (source == FrameSource::kNormals) return {};
  if (mesh.texcoords.size() != mesh.vertexCount())
    throw badInput({mesh_file, "", "/frame"}, "it has no texture coordinates that frames could follow",
                   "a mesh with them, or frame normals");
  transport::TextureFrames frames = transport::textureFrames(mesh);
  if (frames.undetermined > 0)
    run.warn(
        std::to_string(frames.undetermined) +
        " vertices have no direction in their texture coordinates: their frames follow the normal alone");
  return std::move(frames.tangents);
}

void writeTransfer(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                   const TransferSettings& settings, std::span<const Float3> albedo, const Transfer& baked,
                   const std::optional<Cpca>& cpca) {
  const std::uint64_t vertices = mesh.vertexCount(), count = squared(settings.options.order);
  const auto channels = static_cast<std::uint64_t>(baked.channels);
  Contents contents;
  contents.metadata = {{"technique", formats::wordFor(kTechniques, settings.technique)},
                       {"order", std::to_string(settings.options.order)},
                       {"transport", formats::wordFor(kTransports, settings.options.transport)},
                       {"basis", "real_sh_cartesian"},
                       {"albedo", "outside"},
                       {"inverse_pi", "inside"},
                       {"mesh_hash", formats::geometryHash(mesh)}};
  if (settings.options.fit != Fit::kVertices) {
    contents.metadata["fit"] = formats::wordFor(kFits, settings.options.fit);
    contents.metadata["samples"] = std::to_string(settings.options.samples);
  }
  if (settings.options.entered_ior > 0)
    contents.metadata["entered_ior"] = std::to_string(settings.options.entered_ior);
  contents.add("transfer", {vertices, channels, count}, baked.vectors);
  const transport::Vec3& center = baked.sphere.center;
  const std::array<double, 4> sphere = {center.x(), center.y(), center.z(), baked.sphere.radius};
  const std::vector<float> rounded(sphere.begin(), sphere.end());
  if (!baked.near_vectors.empty()) {
    contents.add("near_transfer", {vertices, channels, count}, baked.near_vectors);
    contents.add("sphere", {4}, rounded);
  }
  if (!albedo.empty()) contents.addRows<3>("albedo", albedo);
  if (settings.isGlossy()) addGlossy(settings, baked, cpca, vertices, contents);
  contents.write(path);
}

namespace {

const char* storageName(const Transfer& baked) {
  if (baked.exact_shares) return "exact";
  return baked.share_threshold > 0 ? "sampled" : "16 bits";
}

void reportInterreflection(const TransferSettings& settings, const Transfer& baked, stage::Run& run) {
  const transport::InterreflectionReport& bounced = baked.interreflection;
  run.stat("interreflection_passes", bounced.added_energy.size());
  run.stat("added_energy_per_pass", bounced.added_energy);
  run.stat("interreflection_solver", bounced.solver);
  run.stat("interreflection_error_bound", bounced.error_bound);
  run.stat("largest_return", bounced.largest_return);
  run.stat("form_factors", baked.form_factors);
  run.stat("form_factor_bytes", baked.form_factor_bytes);
  run.stat("form_factor_storage", storageName(baked));
  run.stat("share_threshold", baked.share_threshold);
  run.stat("interreflection_parts", baked.interreflection_parts);
  run.stat("back_points", baked.back_points);
  run.stat("inside_hit_share",
           baked.rays > 0 ? static_cast<double>(baked.inside_hits) / static_cast<double>(baked.rays) : 0.0);
  run.stat("interreflection_s", baked.interreflection_s);
  if (baked.memory_expected > baked.memory_limit)
    run.warn("the bake needs about " + std::to_string(baked.memory_expected / 1'000'000) +
             " MB, more than its memory of " + std::to_string(baked.memory_limit / 1'000'000) +
             " MB: a mesh of fewer triangles needs less");
  if (!bounced.converged && settings.options.interreflection.bounces == 0)
    run.warn("interreflection did not converge: up to " + std::to_string(bounced.error_bound) +
             " of the light may be missing; is the albedo 1 in a closed cavity?");
  if (!bounced.converged && settings.options.interreflection.bounces > 0)
    run.warn("up to " + std::to_string(bounced.error_bound) + " of the light is missing after " +
             std::to_string(bounced.added_energy.size()) + " bounces; bounces 0 goes on until the threshold");
}

void reportFit(const FitFigures& fit, stage::Run& run) {
  run.stat("samples", fit.samples);
  run.stat("buried_samples", fit.buried_samples);
  run.stat("strayed_samples", fit.strayed_samples);
  run.stat("sample_rays", fit.rays);
  run.stat("interpolation_error_at_vertices", fit.error_at_vertices);
  run.stat("interpolation_error", fit.error);
  run.stat("least_shown", fit.least_shown);
  run.stat("most_shown", fit.most_shown);
  run.stat("limited_vertices", fit.limited_vertices);
  run.stat("fit_s", fit.seconds);
  if (2 * fit.strayed_samples > fit.samples)
    run.warn(
        "most samples have nothing of the original near them: is it the mesh that this one was made from?");
}

}  // namespace

void report(const formats::TriangleMesh& mesh, const TransferSettings& settings, const Transfer& baked,
            const std::optional<Cpca>& cpca, double bake_s, stage::Run& run) {
  run.stat("vertices", mesh.vertexCount());
  run.stat("channels", baked.channels);
  run.stat("bake_s", bake_s);
  run.stat("shadow_s", baked.shadow_s);
  run.stat("rays", baked.rays);
  run.stat("rays_per_s", baked.shadow_s > 0 ? static_cast<double>(baked.rays) / baked.shadow_s : 0.0);
  run.stat("blocked_ray_share",
           baked.rays > 0 ? static_cast<double>(baked.blocked_rays) / static_cast<double>(baked.rays) : 0.0);
  run.stat("fully_blocked_vertices", baked.fully_blocked_vertices);
  run.stat("buried_vertices", baked.buried_vertices);
  run.stat("filled_vertices", baked.filled_vertices);
  run.stat("outlying_vertices", baked.outlying_vertices);
  run.stat("resampled_vertices", baked.resampled_vertices);
  run.stat("quadrature_error", baked.quadrature_error);
  if (settings.options.transport == Transport::kInterreflected) reportInterreflection(settings, baked, run);
  if (settings.options.fit == Fit::kLeastSquares) reportFit(baked.fit, run);
  if (settings.isGlossy()) run.stat("matrices_s", baked.matrices_s);
  if (cpca) {
    run.stat("cpca_relative_error", cpca->relative_error);
    run.stat("cpca_clusters", cpca->cluster_count);
  }
  if (settings.options.transport != Transport::kUnshadowed && baked.rays > 0 && baked.blocked_rays == 0)
    run.warn("nothing blocks any ray: transport \"unshadowed\" gives the same result without rays");
  if (baked.fully_blocked_vertices > mesh.vertexCount() / 2)
    run.warn("most vertices see no light at all: is the mesh closed and turned inside out?");
}

}  // namespace bakelight::transfer
