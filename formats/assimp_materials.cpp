#include "formats/assimp_materials.h"

#include <assimp/material.h>
#include <assimp/scene.h>
#include <algorithm>
#include <utility>

#include "formats/error.h"
#include "formats/missing_picture.h"
#include "formats/named_file.h"

namespace bakelight::formats {
namespace {

AlbedoTexture::Wrap wrapOf(const aiMaterial& material, const char* key, unsigned type, unsigned index) {
  int mode = aiTextureMapMode_Wrap;
  if (material.Get(key, type, index, mode) != aiReturn_SUCCESS) return AlbedoTexture::Wrap::kRepeat;
  if (mode == aiTextureMapMode_Mirror) return AlbedoTexture::Wrap::kMirror;
  if (mode == aiTextureMapMode_Clamp || mode == aiTextureMapMode_Decal) return AlbedoTexture::Wrap::kClamp;
  return AlbedoTexture::Wrap::kRepeat;
}

AssimpLookup lookupOf(const aiMaterial& material, aiTextureType type) {
  AssimpLookup lookup;
  int set = 0;
  if (material.Get(AI_MATKEY_UVWSRC(type, 0), set) == aiReturn_SUCCESS && set > 0) {
    lookup.set = static_cast<unsigned>(set);
  }
  aiUVTransform moved;
  if (material.Get(AI_MATKEY_UVTRANSFORM(type, 0), moved) == aiReturn_SUCCESS) {
    lookup.scale = {moved.mScaling.x, moved.mScaling.y};
    lookup.offset = {moved.mTranslation.x, moved.mTranslation.y};
    lookup.rotation = moved.mRotation;
  }
  return lookup;
}

class MaterialReader {
 public:
  MaterialReader(const aiScene& scene, const std::filesystem::path& path, std::vector<std::string>& notes)
      : scene_(scene), path_(path), notes_(notes) {}

  AssimpMaterials read() {
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) add(*scene_.mMaterials[i], i);
    return std::move(result_);
  }

 private:
  void add(const aiMaterial& material, unsigned index) {
    aiString name;
    material.Get(AI_MATKEY_NAME, name);
    const std::string text = name.C_Str();
    // The last is what assimp's 3DS reader makes up.
    if (text == AI_DEFAULT_MATERIAL_NAME || text == "%%%DEFAULT") {
      result_.places.push_back(-1);
      return;
    }
    PartMaterial part{.name = text.empty() ? "material_" + std::to_string(index) : text, .color = {}};
    std::optional<AssimpLookup> lookup;
    aiColor4D color;
    if (material.Get(AI_MATKEY_COLOR_DIFFUSE, color) == aiReturn_SUCCESS) {
      part.color = Float3{color.r, color.g, color.b};
    }
    for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      aiString file;
      if (part.texture >= 0 || material.GetTexture(type, 0, &file) != aiReturn_SUCCESS) continue;
      part.texture = textureAt(file, wrapOf(material, AI_MATKEY_MAPPINGMODE_U(type, 0)),
                               wrapOf(material, AI_MATKEY_MAPPINGMODE_V(type, 0)), part);
      if (part.texture >= 0) lookup = lookupOf(material, type);
    }
    // In these formats the picture stands in the colour's place.
    if (part.texture >= 0) part.color.reset();
    result_.places.push_back(static_cast<int>(result_.materials.size()));
    result_.materials.push_back(std::move(part));
    result_.lookups.push_back(lookup);
  }

  int textureAt(const aiString& file, AlbedoTexture::Wrap wrap_u, AlbedoTexture::Wrap wrap_v,
                const PartMaterial& material) {
    AlbedoTexture texture;
    texture.wrap_u = wrap_u, texture.wrap_v = wrap_v;
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(file.C_Str())) {
      texture.name = path_.string() + ", embedded picture " + file.C_Str();
      if (embedded->mHeight != 0) {
        throw badInput({texture.name, "", ""}, "it is in no picture format", "PNG, JPEG or another one",
                       "export the pictures as files");
      }
      const auto* bytes = reinterpret_cast<const std::byte*>(embedded->pcData);
      texture.bytes.assign(bytes, bytes + embedded->mWidth);
    } else {
      const auto found = findNamedFile(filesOnDisk(), path_.parent_path(), file.C_Str());
      if (!found) {
        noteOnce(missingPicture(path_.string(), file.C_Str(), material.name, material.color));
        return -1;
      }
      if (!found->exact) {
        noteOnce("'" + std::string(file.C_Str()) + "' is taken to mean " + found->path.filename().string());
      }
      texture.path = found->path;
      texture.name = found->path.string();
    }
    for (std::size_t i = 0; i < result_.textures.size(); ++i) {
      const AlbedoTexture& known = result_.textures[i];
      if (known.name == texture.name && known.wrap_u == wrap_u && known.wrap_v == wrap_v)
        return static_cast<int>(i);
    }
    result_.textures.push_back(std::move(texture));
    return static_cast<int>(result_.textures.size() - 1);
  }

  void noteOnce(const std::string& text) {
    if (std::find(notes_.begin(), notes_.end(), text) == notes_.end()) notes_.push_back(text);
  }

  const aiScene& scene_;
  const std::filesystem::path& path_;
  std::vector<std::string>& notes_;
  AssimpMaterials result_;
};

}  // namespace

AssimpMaterials assimpMaterials(const aiScene& scene, const std::filesystem::path& path,
                                std::vector<std::string>& notes) {
  return MaterialReader(scene, path, notes).read();
}

}  // namespace bakelight::formats
