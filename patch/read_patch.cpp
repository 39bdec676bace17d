#include "patch/read_patch.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "formats/color_picture.h"
#include "formats/error.h"
#include "formats/image.h"
#include "formats/mesh_import.h"
#include "patch/height_field.h"
#include "patch/mesh_patch.h"

namespace bakelight::patch {
namespace {

using formats::Image;

PatchGeometry readHeightField(const formats::Patch& patch) {
  const std::string name = patch.height->file.string();
  return heightField(formats::readImage(patch.height->file), patch.height->depth, patch.periodic, name);
}

PatchGeometry readMeshPatch(const formats::Patch& patch) {
  const std::string name = patch.geometry->file.string();
  const formats::MeshImport import = formats::importMesh(patch.geometry->file);
  PatchGeometry geometry = meshPatch(import.mesh, *patch.geometry, patch.periodic, name);
  geometry.notes.insert(geometry.notes.begin(), import.notes.begin(), import.notes.end());
  if (!import.textures.empty() && patch.texture.empty())
    geometry.notes.push_back(name +
                             ": its materials' pictures are not read; the patch's \"texture\" would be");
  return geometry;
}

// Of a flat patch the picture that is laid out is its colors.
std::filesystem::path pictureOf(const formats::Patch& patch) {
  const bool is_flat = !patch.height && !patch.geometry;
  return patch.texture.empty() && is_flat ? patch.file : patch.texture;
}

// As wide as its picture is to its height: triangles for each texel would say no more.
PatchGeometry flatPatch(const formats::Patch& patch) {
  const std::filesystem::path file = pictureOf(patch);
  const Image picture = formats::readImage(file);
  const int factor = std::gcd(std::max(picture.width, 1), std::max(picture.height, 1));
  return heightField(Image(4 * picture.width / factor, 4 * picture.height / factor, {"height"}), 0,
                     patch.periodic, file.string());
}

void clampToReflectance(Image& picture, const std::string& name, std::vector<std::string>& notes) {
  std::size_t beyond = 0;
  for (float& value : picture.values)
    if (value < 0 || value > 1) value = std::min(std::max(value, 0.0F), 1.0F), ++beyond;
  if (beyond > 0)
    notes.push_back(name + ": " + std::to_string(beyond) +
                    " values outside 0–1 are no reflectance, and clamped");
}

void giveAlbedo(const formats::Material& material, PatchGeometry& geometry) {
  const formats::Patch& patch = *material.patch;
  const std::filesystem::path file = pictureOf(patch);
  if (!file.empty()) {
    formats::ColorPicture picture = formats::readColorPicture(file, formats::PictureUse::kReflectance);
    geometry.notes.insert(geometry.notes.end(), picture.notes.begin(), picture.notes.end());
    clampToReflectance(picture.image, file.string(), geometry.notes);
    geometry.texture = std::move(picture.image);
  }
  const bool is_own = patch.albedo || !file.empty();
  if (is_own) geometry.mesh.colors.clear();
  if (patch.albedo)
    geometry.albedo = *patch.albedo;
  else if (!is_own && geometry.mesh.colors.empty())
    geometry.albedo = material.albedo.value_or(formats::kDefaultAlbedo);
}

}  // namespace

PatchGeometry readPatch(const formats::Material& material) {
  if (!material.patch || !material.patch->hasSurface()) throw std::logic_error("a patch without a surface");
  const formats::Patch& patch = *material.patch;
  PatchGeometry geometry = patch.height     ? readHeightField(patch)
                           : patch.geometry ? readMeshPatch(patch)
                                            : flatPatch(patch);
  giveAlbedo(material, geometry);
  geometry.reflection = material.reflection;
  return geometry;
}

}  // namespace bakelight::patch
