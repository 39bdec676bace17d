#include "formats/obj_materials.h"

#include <algorithm>
#include <unordered_map>

#include "formats/error.h"
#include "formats/missing_picture.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

// One of the files of a line `mtllib`.
struct LibraryFile {
  std::string name;
  std::optional<NamedFile> file;
};

bool endsAsLibrary(std::string_view word) {
  return word.size() >= 4 && equalIgnoringCase(word.substr(word.size() - 4), ".mtl");
}

// Names are separated by blanks and contain them: a line that is the name of a file means that file;
// otherwise a name goes on until a word ends in ".mtl".
std::vector<std::string> librariesIn(const std::string& line, const fs::path& folder,
                                     const FileLookup& files) {
  if (findNamedFile(files, folder, line)) return {line};
  std::vector<std::string> names;
  std::string name;
  std::string_view rest = line;
  for (auto word = takeWord(rest); !word.empty(); word = takeWord(rest)) {
    name += (name.empty() ? "" : " ") + std::string(word);
    if (!endsAsLibrary(word) && !findNamedFile(files, folder, name)) continue;
    names.push_back(std::move(name));
    name.clear();
  }
  if (!name.empty()) names.push_back(name);
  return names;
}

std::string textOf(const FileLookup& files, const fs::path& path) {
  std::string text = files.read(path);
  auto converted = utf8FromUtf16(text);
  return converted ? std::move(*converted) : text;
}

class MaterialFinder {
 public:
  MaterialFinder(const fs::path& folder, const FileLookup& files) : folder_(folder), files_(files) {}

  void readLibraries(const std::vector<ObjStatements::Library>& libraries) {
    std::vector<fs::path> read;
    for (const ObjStatements::Library& library : libraries)
      for (const std::string& name : librariesIn(library.names, folder_, files_)) {
        const auto found = findNamedFile(files_, folder_, name);
        if (!found) {
          note("line " + std::to_string(library.line) + ": the material library '" + name +
               "' does not exist: its materials have their names, and no colour");
          continue;
        }
        if (std::find(read.begin(), read.end(), found->path) != read.end()) continue;
        read.push_back(found->path);
        if (!found->exact)
          note("line " + std::to_string(library.line) + ": '" + name + "' is taken to mean " +
               found->path.filename().string());
        readLibrary(found->path);
      }
  }

  ObjMaterials find(const std::vector<std::string>& names) {
    std::vector<std::string> missing;
    for (const std::string& name : names) {
      PartMaterial material{.name = name, .color = {}, .texture = -1};
      MtlTexture lookup;
      if (const auto known = known_.find(name); known != known_.end()) {
        material.color = known->second.material.color;
        if (known->second.material.texture) {
          lookup = *known->second.material.texture;
          material.texture = textureOf(lookup, known->second.library, material);
        }
      } else if (!known_.empty()) {
        missing.push_back(name);
      }
      result_.materials.push_back(std::move(material));
      result_.lookups.push_back(std::move(lookup));
    }
    if (!missing.empty())
      note((missing.size() == 1
                ? "the material '" + missing[0] + "' is"
                : std::to_string(missing.size()) + " materials ('" + missing[0] + "', …) are") +
           " in none of the material libraries, and without colour");
    return std::move(result_);
  }

 private:
  struct Known {
    MtlMaterial material;
    fs::path library;
  };

  void note(std::string text) { result_.notes.push_back(std::move(text)); }

  void readLibrary(const fs::path& path) {
    MtlFile library = readMtl(textOf(files_, path), path.string());
    for (MtlMaterial& material : library.materials) {
      const std::string name = material.name;
      known_.try_emplace(name, Known{std::move(material), path});
    }
    result_.notes.insert(result_.notes.end(), library.notes.begin(), library.notes.end());
  }

  int textureOf(const MtlTexture& texture, const fs::path& library, const PartMaterial& material) {
    auto found = findNamedFile(files_, library.parent_path(), texture.name);
    if (!found) found = findNamedFile(files_, folder_, texture.name);
    const std::string place = library.string() + ", line " + std::to_string(texture.line);
    if (!found) {
      noteOnce(missingPicture(place, texture.name, material.name, material.color));
      return -1;
    }
    if (!found->exact)
      noteOnce(place + ": '" + texture.name + "' is taken to mean " + found->path.filename().string());
    using Wrap = AlbedoTexture::Wrap;
    const Wrap wrap = texture.clamp ? Wrap::kClamp : Wrap::kRepeat;
    for (std::size_t i = 0; i < result_.textures.size(); ++i)
      if (result_.textures[i].path == found->path && result_.textures[i].wrap_u == wrap)
        return static_cast<int>(i);
    result_.textures.push_back(
        {.name = found->path.string(), .path = found->path, .wrap_u = wrap, .wrap_v = wrap});
    return static_cast<int>(result_.textures.size() - 1);
  }

  void noteOnce(const std::string& text) {
    if (std::find(result_.notes.begin(), result_.notes.end(), text) == result_.notes.end()) note(text);
  }

  const fs::path& folder_;
  const FileLookup& files_;
  std::unordered_map<std::string, Known> known_;
  ObjMaterials result_;
};

}  // namespace

ObjMaterials objMaterials(const std::vector<std::string>& names,
                          const std::vector<ObjStatements::Library>& libraries, const fs::path& folder,
                          const FileLookup& files) {
  MaterialFinder finder(folder, files);
  finder.readLibraries(libraries);
  return finder.find(names);
}

std::vector<fs::path> filesOfLibraries(const std::vector<ObjStatements::Library>& libraries,
                                       const fs::path& folder, const FileLookup& files) {
  std::vector<fs::path> result;
  for (const ObjStatements::Library& library : libraries)
    for (const std::string& name : librariesIn(library.names, folder, files)) {
      const auto found = findNamedFile(files, folder, name);
      result.push_back(found ? found->path : plainPathOf(folder, name));
      if (!found) continue;
      MtlFile contents;
      try {
        contents = readMtl(textOf(files, found->path), found->path.string());
      } catch (const Error&) {
        continue;  // the importer will say what is wrong with it
      }
      for (const MtlMaterial& material : contents.materials) {
        if (!material.texture) continue;
        const fs::path beside = found->path.parent_path();
        auto picture = findNamedFile(files, beside, material.texture->name);
        if (!picture) picture = findNamedFile(files, folder, material.texture->name);
        result.push_back(picture ? picture->path : plainPathOf(beside, material.texture->name));
      }
    }
  return result;
}

}  // namespace bakelight::formats
