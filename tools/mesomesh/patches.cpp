#include "tools/mesomesh/patches.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "formats/color_picture.h"
#include "tools/mesomesh/transfer_exemplar.h"

namespace bakelight::mesomesh {

using formats::Float2;
using formats::Float3;
using formats::Image;

namespace {

const std::vector<std::string> kColors = {"R", "G", "B"};

// What has no patch looks the same everywhere.
Image plainTexel(const formats::Material& material) {
  Image image(1, 1, kColors);
  const Float3 albedo = material.albedo.value_or(formats::kDefaultAlbedo);
  std::copy(albedo.begin(), albedo.end(), image.values.begin());
  return image;
}

// Channels that are no color (of heights, or of a transfer) are shown as the first of them in gray.
Image colorsOf(const std::filesystem::path& file, const Image& image) {
  try {
    return formats::readColorPicture(file, formats::PictureUse::kReflectance).image;
  } catch (const Error&) {
    Image gray(image.width, image.height, kColors);
    const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        std::fill_n(gray.texel(x, y), 3,
                    *high > *low ? (image.texel(x, y)[0] - *low) / (*high - *low) : 0.5F);
    return gray;
  }
}

// What an exemplar is made of.
struct Source {
  std::string name;
  Image appearance, colors;
  std::optional<Image> turn_invariant = {};  // where another picture tells of its symmetry
};

Source sourceFrom(const formats::Material& material) {
  if (!material.patch) return {"a plain material", plainTexel(material), plainTexel(material)};
  Image image = formats::readImage(material.patch->file);
  Image colors = colorsOf(material.patch->file, image);
  return {material.patch->file.string(), std::move(image), std::move(colors)};
}

Source sourceFrom(const formats::RadianceTransferTexture& texture) {
  return {"the transfer texture of the material \"" + texture.material + "\"", appearanceOf(texture),
          zenithColors(texture), turnInvariant(texture)};
}

const formats::RadianceTransferTexture& textureOf(std::span<const formats::RadianceTransferTexture> transfer,
                                                  const std::string& name, const std::string& file) {
  const auto found = std::find_if(transfer.begin(), transfer.end(),
                                  [&](const auto& texture) { return texture.material == name; });
  if (found != transfer.end()) return *found;
  throw badInput({file, "", name.empty() ? "/patch" : formats::childPointer("/materials", name) + "/patch"},
                 "the patch has no picture to lay out, and no transfer texture of it is given",
                 "\"file\": a picture, or input rtt: what the tool rtt made of these materials");
}

void add(Patches& patches, Source source, const std::optional<formats::Patch>& patch) {
  ExemplarSettings settings;
  if (patch) settings.periodic = patch->periodic;
  if (patch && patch->width) settings.texel_size = *patch->width / source.appearance.width;
  Exemplar exemplar = makeExemplar(source.appearance, settings, source.name);
  if (source.turn_invariant)
    exemplar.symmetry = makeExemplar(*source.turn_invariant, settings, source.name).symmetry;
  patches.colors.push_back(std::move(source.colors));
  patches.exemplars.push_back(std::move(exemplar));
}

}  // namespace

int Patches::folds() const {
  int folds = 4;
  for (const Exemplar& exemplar : exemplars)
    if (exemplar.texelCount() > 1) folds = std::min(folds, exemplar.symmetry.folds());
  return folds;
}

bool hasPatches(const formats::Materials& materials) {
  return materials.base.patch ||
         std::any_of(materials.by_name.begin(), materials.by_name.end(),
                     [](const auto& entry) { return entry.second.patch.has_value(); });
}

Patches readPatches(const formats::Materials& materials, const std::vector<std::string>& material_names,
                    const std::string& file, std::span<const formats::RadianceTransferTexture> transfer) {
  for (const auto& [name, material] : materials.by_name)
    if (std::find(material_names.begin(), material_names.end(), name) == material_names.end())
      throw badInput({file, "", formats::childPointer("/materials", name)},
                     "no face of the mesh has a material of the name \"" + name + "\"");
  Patches patches;
  std::vector<std::optional<formats::Patch>> known;
  const auto exemplarOf = [&](const std::string& name, const formats::Material& material) {
    const auto same = std::find(known.begin(), known.end(), material.patch);
    if (same != known.end() && material.patch) return static_cast<std::uint32_t>(same - known.begin());
    const auto place = static_cast<std::uint32_t>(known.size());
    known.push_back(material.patch);
    add(patches,
        material.patch && material.patch->file.empty()
            ? sourceFrom(textureOf(transfer, materials.by_name.contains(name) ? name : "", file))
            : sourceFrom(material),
        material.patch);
    return place;
  };
  if (material_names.empty()) patches.of_material = {exemplarOf("", materials.base)};
  for (const std::string& name : material_names)
    patches.of_material.push_back(exemplarOf(name, materials.of(name)));
  return patches;
}

std::vector<Float3> colorsAt(const Patches& patches, const std::vector<Float2>& places,
                             const std::vector<std::uint32_t>& materials) {
  std::vector<Float3> colors(places.size());
  for (std::size_t v = 0; v < colors.size(); ++v) {
    const Image& image = patches.colors[patches.of_material[materials[v]]];
    const auto texelOf = [](float place, int side) {
      return std::clamp(static_cast<int>(static_cast<double>(place) * side), 0, side - 1);
    };
    const float* texel = image.texel(texelOf(places[v][0], image.width),
                                     image.height - 1 - texelOf(places[v][1], image.height));
    std::copy_n(texel, 3, colors[v].begin());
  }
  return colors;
}

void layOut(const Patches& patches, const SynthesisOptions& options, const std::string& mesh_file,
            formats::MesoMesh& meso, stage::Run& run) {
  std::vector<std::uint32_t> exemplars(meso.materials.size());
  std::transform(meso.materials.begin(), meso.materials.end(), exemplars.begin(),
                 [&](std::uint32_t material) { return patches.of_material[material]; });
  SurfaceView surface{meso.mesh.positions, meso.mesh.normals, meso.tangents, meso.mesh.triangles, exemplars};
  surface.name = mesh_file;
  PatchCoordinates made = synthesize(surface, patches.exemplars, options);
  meso.patch = std::move(made.coordinates);
  meso.mesh.colors = colorsAt(patches, meso.patch, meso.materials);

  const SynthesisQuality& quality = made.report.quality;
  run.stat("neighborhood_error", quality.neighborhood_error);
  run.stat("neighborhood_error_ratio", quality.neighborhood_error_ratio);
  run.stat("coherent_share", quality.coherent_share);
  run.stat("coverage", quality.coverage);
  run.stat("entropy", quality.entropy);
  run.stat("seam_ratio", quality.seam_ratio);
  run.stat("seam_vertices", quality.seam_vertices);
  formats::Json patch_figures = formats::Json::array();
  for (std::size_t e = 0; e < patches.exemplars.size(); ++e) {
    const Exemplar& exemplar = patches.exemplars[e];
    patch_figures.push_back({{"file", exemplar.name},
                             {"width", exemplar.width},
                             {"height", exemplar.height},
                             {"texel_size", made.report.texel_sizes[e]},
                             {"quarter_turn_likeness", exemplar.symmetry.quarter.likeness},
                             {"half_turn_likeness", exemplar.symmetry.half.likeness}});
  }
  run.stat("patches", patch_figures);
}

}  // namespace bakelight::mesomesh
