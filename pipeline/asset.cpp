#include "pipeline/asset.h"

#include <algorithm>
#include <utility>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json_reader.h"
#include "formats/words.h"

namespace bakelight::pipeline {
namespace fs = std::filesystem;
using formats::Json;
using formats::JsonReader;
namespace {

constexpr const char* kAssetFile = "asset.json";
constexpr const char* kMeshPort = "mesh";
constexpr const char* kTexturePort = "texture";
constexpr const char* kMaterialKind = "material";
constexpr std::string_view kDataPrefix = "data:";

// Materials by the names that the mesh gives its faces stand beside that of all: "materials".
std::string pluralOf(const std::string& port) {
  return port + "s";
}

bool endsAs(const fs::path& path, const AssetPort& port) {
  return std::find(port.endings.begin(), port.endings.end(), formats::lowerEnding(path)) !=
         port.endings.end();
}

// "." and "models/" have names too.
std::string folderName(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return whole.has_filename() ? whole.filename().string() : whole.parent_path().filename().string();
}

class Finder {
 public:
  Finder(const fs::path& data_folder, RecipeBook& recipes, const Disk& disk, Problems& problems)
      : data_folder_(data_folder), recipes_(recipes), disk_(disk), problems_(problems) {}

  void find(const fs::path& path) {
    const auto stat = disk_.stat(path);
    if (!stat) throw badInput({path.string(), "", ""}, "does not exist", "an asset folder or a mesh file");
    if (stat->folder)
      findInFolder(path);
    else if (path.filename() == kAssetFile)
      readAssetFile(path);
    else if (endsAs(path, defaultPort(kMeshPort)))
      addMesh(path, path.stem().string());
    else
      throw badInput({path.string(), "", ""}, "is not a mesh file",
                     "a file that ends in " + formats::join(defaultPort(kMeshPort).endings, ", ") +
                         ", or a folder with such a file or asset.json");
  }

  std::vector<Asset> take() {
    for (Asset& asset : assets_)
      problems_.attempt([&] { addDefaultMaterials(recipes_.require(asset.recipe, {}), asset); });
    return std::move(assets_);
  }

 private:
  static void addDefaultMaterials(const Recipe& recipe, Asset& asset) {
    for (const auto& [name, port] : recipe.asset)
      if (port.kind == kMaterialKind && !port.otherwise.is_null() && !asset.supplies(name))
        asset.materials[name] = {defaultMaterial(recipe, name)};
  }

  const Recipe& defaultRecipe() { return recipes_.require(RecipeBook::kDefault, {}); }
  const AssetPort& defaultPort(const std::string& name) { return defaultRecipe().asset.at(name); }

  std::vector<fs::path> filesFor(const AssetPort& port, const fs::path& folder) const {
    std::vector<fs::path> found;
    for (const std::string& name : disk_.list(folder))
      if (!name.starts_with('.') && endsAs(name, port) && disk_.isFile(folder / name))
        found.push_back(folder / name);
    return found;
  }

  // Sub-folders that are assets themselves: with asset.json, or with a mesh.
  std::vector<fs::path> assetFoldersIn(const fs::path& folder) {
    std::vector<fs::path> found;
    for (const std::string& name : disk_.list(folder)) {
      const fs::path inner = folder / name;
      if (name.starts_with('.') || !disk_.isFolder(inner)) continue;
      if (disk_.isFile(inner / kAssetFile) || !filesFor(defaultPort(kMeshPort), inner).empty())
        found.push_back(inner);
    }
    return found;
  }

  void findInFolder(const fs::path& folder) {
    if (disk_.isFile(folder / kAssetFile)) return readAssetFile(folder / kAssetFile);
    const std::vector<fs::path> meshes = filesFor(defaultPort(kMeshPort), folder);
    const std::vector<fs::path> folders = assetFoldersIn(folder);
    if (meshes.empty() && folders.empty())
      throw badInput({folder.string(), "", ""}, "has no asset",
                     "asset.json, a mesh file (" + formats::join(defaultPort(kMeshPort).endings, ", ") +
                         "), or sub-folders with these");
    if (meshes.size() == 1 && folders.empty()) return addFolderWithOneMesh(folder, meshes.front());
    addMeshes(meshes);
    for (const fs::path& inner : folders) problems_.attempt([&] { addSubFolder(inner); });
  }

  void addSubFolder(const fs::path& folder) {
    if (disk_.isFile(folder / kAssetFile)) return readAssetFile(folder / kAssetFile);
    const std::vector<fs::path> meshes = filesFor(defaultPort(kMeshPort), folder);
    if (meshes.size() > 1)
      throw badInput({folder.string(), "", ""}, "has " + std::to_string(meshes.size()) + " mesh files",
                     "one mesh file, or an asset.json that names one",
                     "name that folder itself on the command line");
    addFolderWithOneMesh(folder, meshes.front());
  }

  // Of one folder: where cat.obj lies beside cat.ply, each keeps its ending.
  void addMeshes(const std::vector<fs::path>& meshes) {
    std::map<std::string, int> count;
    for (const fs::path& mesh : meshes) ++count[mesh.stem().string()];
    for (const fs::path& mesh : meshes)
      addMesh(mesh, (count[mesh.stem().string()] > 1 ? mesh.filename() : mesh.stem()).string());
  }

  void addMesh(const fs::path& mesh, const std::string& name) {
    assets_.push_back({.name = name, .label = {}, .file = mesh.string(), .files = {{kMeshPort, mesh}}});
  }

  // Files for the other ports count if there is one candidate only; with two, the user has to say which.
  void addFolderWithOneMesh(const fs::path& folder, const fs::path& mesh) {
    addMesh(mesh, folderName(folder));
    for (const auto& [name, port] : defaultRecipe().asset) {
      if (name == kMeshPort) continue;
      const std::vector<fs::path> candidates = filesFor(port, folder);
      if (candidates.size() == 1) assets_.back().files[name] = candidates.front();
    }
  }

  void readAssetFile(const fs::path& file) {
    const Json json = formats::parseJson(disk_.read(file), file.string());
    const JsonReader object(json, file.string());
    Asset asset{.name = "", .label = {}, .file = file.string()};
    asset.recipe = object.text("recipe", RecipeBook::kDefault);
    const Recipe& recipe = recipes_.require(asset.recipe, object.placeOf("recipe"));

    std::vector<std::string> keys = {"name", "recipe", "stages", "deliver", "leave_out", "report", "budget"};
    for (const auto& [name, port] : recipe.asset) {
      keys.push_back(name);
      if (port.kind == kMaterialKind) keys.push_back(pluralOf(name));
    }
    problems_.add(object.unknownKeys(keys));
    problems_.attempt(
        [&] { asset.name = object.text("name", folderName(fs::absolute(file).parent_path())); });
    problems_.attempt([&] {
      object.object("stages");
      if (object.has("stages")) asset.stages = object.value("stages");
    });
    problems_.attempt([&] {
      if (object.has("deliver")) asset.deliver = object.texts("deliver");
    });
    problems_.attempt([&] { readLeaveOut(object, recipe, asset); });
    problems_.attempt([&] {
      object.object("report");
      if (object.has("report")) asset.report = object.value("report");
      problems_.add(object.object("report").unknownKeys({"lights", "cameras", "vary", "with_run", "truth"}));
      asset.report_with_run = object.object("report").boolean("with_run", false);
      const JsonReader lights = object.object("report").object("lights");
      for (const std::string& name : lights.keys())
        problems_.attempt([&] { asset.report_lights[name] = fileNamed(lights, name, file.parent_path()); });
    });
    if (object.has("budget")) asset.budget = object.value("budget");
    for (const auto& [name, port] : recipe.asset)
      problems_.attempt([&, name = name, kind = port.kind, required = port.required] {
        if (kind == kMaterialKind) return readMaterials(object, name, recipe, asset);
        if (!object.has(name) && !required) return;
        asset.files[name] = fs::path();  // one mistake: it is not missing for the stages that need it as well
        asset.files[name] = fileNamed(object, name, file.parent_path());
      });
    assets_.push_back(std::move(asset));
  }

  void readLeaveOut(const JsonReader& object, const Recipe& recipe, Asset& asset) {
    if (!object.has("leave_out") || !object.value("leave_out").is_object()) {
      asset.keep_all = !object.boolean("leave_out", true);
      return;
    }
    const JsonReader stages = object.object("leave_out");
    problems_.add(stages.unknownKeys(recipe.stageNames()));
    for (const std::string& stage : stages.keys())
      if (!stages.boolean(stage, true)) asset.kept.insert(stage);
  }

  void readMaterials(const JsonReader& object, const std::string& port, const Recipe& recipe, Asset& asset) {
    const fs::path folder = fs::path(asset.file).parent_path();
    formats::Materials materials;
    const Json& otherwise = recipe.asset.at(port).otherwise;
    if (object.has(port)) {
      materials.base = materialAt(object, port, folder, otherwise);
      if (!materials.base.texture.empty()) takeTexture(object, port, recipe, materials.base, asset);
    }
    const JsonReader named = object.object(pluralOf(port));
    for (const std::string& name : named.keys())
      problems_.attempt([&] {
        const formats::Material material = materialAt(named, name, folder, otherwise);
        if (!material.texture.empty())
          throw badInput(named.placeOf(name), "a texture of one of several materials is not read from here",
                         "an albedo of three numbers", "name the picture in the mesh's own material");
        materials.by_name[name] = material;
      });
    if (!object.has(port) && !object.has(pluralOf(port))) return;
    if (!object.has(port)) materials.base = defaultMaterial(recipe, port);
    asset.materials[port] = std::move(materials);
  }

  // Inline, or a file of its own.
  formats::Material materialAt(const JsonReader& object, const std::string& key, const fs::path& folder,
                               const Json& otherwise) const {
    const auto whole = [&](const Json& given) {
      Json json = given;
      if (given.is_object() && otherwise.is_object()) {
        json = otherwise;
        json.update(given);
      }
      return json;
    };
    const auto files = [this](const fs::path& base) {
      return [this, base](const std::string& text, const ErrorPlace& place) {
        return resolved(text, place, base);
      };
    };
    if (!object.value(key).is_string())
      return formats::materialFromJson(whole(object.value(key)), object.placeOf(key).file,
                                       object.placeOf(key).pointer, files(folder));
    const fs::path path = fileNamed(object, key, folder);
    const Json json = formats::parseJson(disk_.read(path), path.string());
    return formats::materialFromJson(whole(json), path.string(), "", files(path.parent_path()));
  }

  static formats::Material defaultMaterial(const Recipe& recipe, const std::string& port) {
    const Json& otherwise = recipe.asset.at(port).otherwise;
    if (otherwise.is_null()) return {};
    return formats::materialFromJson(otherwise, recipe.file, "/asset/" + port + "/default",
                                     [](const std::string&, const ErrorPlace& place) -> fs::path {
                                       throw badInput(place, "a recipe's material names a file",
                                                      "numbers alone");
                                     });
  }

  // The picture becomes colours of the mesh: from then on these are the albedo.
  static void takeTexture(const JsonReader& object, const std::string& port, const Recipe& recipe,
                          formats::Material& material, Asset& asset) {
    if (recipe.asset.count(kTexturePort) == 0)
      throw badInput(object.placeOf(port), "the recipe " + recipe.name + " takes no texture",
                     "an albedo of three numbers");
    if (object.has(kTexturePort))
      throw badInput(object.placeOf(port), "the albedo is a texture, and the asset has another \"texture\"",
                     "one texture", "leave \"texture\" out");
    asset.files[kTexturePort] = std::exchange(material.texture, fs::path());
  }

  fs::path fileNamed(const JsonReader& object, const std::string& key, const fs::path& folder) const {
    return resolved(object.text(key), object.placeOf(key), folder);
  }

  fs::path resolved(const std::string& text, const ErrorPlace& place, const fs::path& folder) const {
    const bool in_data = text.starts_with(kDataPrefix);
    const fs::path path = in_data ? data_folder_ / text.substr(kDataPrefix.size()) : folder / text;
    if (!disk_.isFile(path))
      throw badInput(place, "there is no file " + path.lexically_normal().string(), "",
                     in_data ? "run `make assets`, or name the data folder with --data" : "correct the path");
    return path.lexically_normal();
  }

  const fs::path& data_folder_;
  RecipeBook& recipes_;
  const Disk& disk_;
  Problems& problems_;
  std::vector<Asset> assets_;
};

void checkNames(const std::vector<Asset>& assets, Problems& problems) {
  std::map<std::string, std::string> file_of;
  for (const Asset& asset : assets) {
    if (asset.name.empty() || asset.name.starts_with('.') || asset.name.find('/') != std::string::npos)
      problems.add(badInput({asset.file, "", ""}, "\"" + asset.name + "\" cannot be the name of an asset",
                            "a name for a folder, not starting with a dot"));
    const auto [other, is_new] = file_of.emplace(asset.name, asset.file);
    if (!is_new)
      problems.add(badInput(
          {asset.file, "", ""},
          "is a second asset of the name \"" + asset.name + "\"; the first is " + other->second,
          "each name once, as it names a folder of outputs",
          "rename one of the files, or put it into a folder with an asset.json that gives a \"name\""));
  }
}

}  // namespace

Setting parseSetting(const std::string& text) {
  const std::size_t equals = text.find('='), dot = text.substr(0, equals).find('.');
  const std::string option = "--set " + text;
  if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 == equals)
    throw Error(ExitStatus::kUsage, {option, "", ""}, "is no setting", "--set stage.parameter=value",
                "--set transfer.order=5, for example");
  return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1), option};
}

std::vector<Asset> findAssets(const std::vector<fs::path>& paths, const fs::path& data_folder,
                              RecipeBook& recipes, const Disk& disk, Problems& problems) {
  Finder finder(data_folder, recipes, disk, problems);
  for (const fs::path& path : paths) problems.attempt([&] { finder.find(path); });
  std::vector<Asset> assets = finder.take();
  checkNames(assets, problems);
  return assets;
}

}  // namespace bakelight::pipeline
