#include "tools/inspect/inspect.h"

#include "formats/btf_pictures.h"
#include "formats/color_picture.h"
#include "formats/error.h"
#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"
#include "tools/inspect/btf_preview.h"
#include "tools/inspect/describe.h"
#include "tools/inspect/file_kind.h"
#include "tools/inspect/patch_figures.h"
#include "tools/inspect/patch_preview.h"
#include "tools/inspect/rtt_view.h"

namespace bakelight::inspect {
namespace {

using Options = std::optional<PreviewOptions>;

// In our own PLY the order of vertices counts, which the strict reader keeps.
formats::MeshImport readMesh(const std::filesystem::path& path) {
  if (formats::isStagePly(path)) {
    try {
      return {.mesh = formats::readPly(path)};
    } catch (const Error&) {
      // One that importMesh has the right words about.
    }
  }
  return formats::importMesh(path);
}

Preview previewThrough(const PatchFiles& patch, const formats::TriangleMesh& mesh,
                       const PreviewOptions& options, const std::string& file) {
  std::optional<formats::Image> exemplar;
  if (!patch.exemplar.empty())
    exemplar = formats::readColorPicture(patch.exemplar, formats::PictureUse::kReflectance).image;
  return previewThroughIdMap(mesh, readIdMap(patch.id_map), exemplar, options, file);
}

void inspectMesh(const std::filesystem::path& path, const Options& options, const PatchFiles& patch,
                 Inspection& inspection) {
  const formats::MeshImport import = readMesh(path);
  inspection.summary.sections = describeMesh(import.mesh, import.notes);
  if (!options) return;
  if (!patch.id_map.empty())
    inspection.preview = previewThrough(patch, import.mesh, *options, path.string());
  else if (options->showsTexcoords())
    inspection.preview = previewAtlas(import.mesh, *options, path.string());
  else if (options->paint == Paint::kColors)
    inspection.preview = previewColors(import.mesh, *options, path.string());
  else if (options->paint == Paint::kMaterials)
    inspection.preview = previewMaterials(import.mesh, *options, path.string());
  else
    inspection.preview = previewMesh(import.mesh, *options, path.string());
}

void inspectMesoMesh(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::MesoMesh meso = formats::readMesoMesh(path);
  inspection.summary.sections = describeMesoMesh(meso);
  if (options) inspection.preview = previewMesoMesh(meso, *options, path.string());
}

void inspectIdMap(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::IndexImage ids = readIdMap(path);
  inspection.summary.sections = describeIdMap(ids);
  if (options) inspection.preview = previewIdMap(ids, *options);
}

void inspectRtt(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const std::vector<formats::RadianceTransferTexture> textures = formats::readRadianceTransferTextures(path);
  inspection.summary.sections = describeRtt(textures);
  if (options) inspection.preview = previewRtt(textures, *options);
}

void inspectImage(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::Image image = formats::readImage(path, formats::NonFinite::kKeep);
  const std::string ending = formats::lowerEnding(path);
  const bool display_encoded = ending != ".exr" && ending != ".hdr";
  inspection.summary.sections = describeImage(image, path.string());
  if (options) inspection.preview = previewImage(image, display_encoded, *options);
}

void inspectBtf(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const std::unique_ptr<formats::Btf> btf =
      formats::isPictureSet(path) ? formats::openBtfPictures(path) : formats::openBtf(path);
  inspection.summary.file_bytes = btf->info().bytes;
  const BtfSheet sheet = sheetOf(*btf);
  inspection.summary.sections = describeBtf(*btf, sheet);
  if (options) inspection.preview = previewBtf(*btf, sheet, *options);
}

void inspectTensors(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::TensorFile tensors = formats::readSafetensors(path);
  inspection.summary.sections = describeTensors(tensors);
  if (options) inspection.preview = previewTensors(tensors, *options, path.string());
}

void inspectPack(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::Bytes bytes = formats::readFile(path);
  const formats::Pack pack = formats::decodePack(bytes, path.string());
  inspection.summary.sections = describePack(pack, bytes, path.string());
  if (!options) return;
  if (options->showsTexcoords())
    inspection.preview = previewAtlas(pack.mesh, *options, path.string());
  else if (options->paint == Paint::kMaterials)
    inspection.preview = previewMaterials(pack.mesh, *options, path.string());
  else
    inspection.preview = previewPack(pack, *options, path.string());
}

void inspectMaterial(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  inspection.summary.sections = describeMaterials(formats::readMaterials(path));
  if (options)
    throw badInput({path.string(), "", ""}, "a material alone has nothing to draw",
                   "a mesh, image, tensors or pack", "leave out --preview");
}

void inspectRecord(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  inspection.summary.sections = describeRecord(formats::readJson(path), path.string());
  if (options)
    throw badInput({path.string(), "", ""}, "a record has nothing to draw", "a mesh, image, tensors or pack",
                   "leave out --preview");
}

}  // namespace

Inspection inspectFile(const std::filesystem::path& path, const Options& preview, const PatchFiles& patch) {
  const FileKind kind = kindOfFile(path);
  if (!patch.id_map.empty() && kind != FileKind::kMesh)
    throw badInput({path.string(), "", ""},
                   std::string("a ") + nameOf(kind) + " shows nothing through an id map",
                   "the mesh of the atlas that the id map was made with");
  if (patch.id_map.empty() && !patch.exemplar.empty())
    throw Error(ExitStatus::kUsage, {"", "--exemplar", ""}, "an exemplar is shown through an id map only",
                "--id-map, too");
  Inspection inspection;
  inspection.summary.file = path.string();
  inspection.summary.kind = nameOf(kind);
  if (kind != FileKind::kBtf) inspection.summary.file_bytes = std::filesystem::file_size(path);
  switch (kind) {
    case FileKind::kMesh:
      inspectMesh(path, preview, patch, inspection);
      break;
    case FileKind::kImage:
      inspectImage(path, preview, inspection);
      break;
    case FileKind::kTensors:
      inspectTensors(path, preview, inspection);
      break;
    case FileKind::kPack:
      inspectPack(path, preview, inspection);
      break;
    case FileKind::kMaterial:
      inspectMaterial(path, preview, inspection);
      break;
    case FileKind::kRecord:
      inspectRecord(path, preview, inspection);
      break;
    case FileKind::kMesoMesh:
      inspectMesoMesh(path, preview, inspection);
      break;
    case FileKind::kIdMap:
      inspectIdMap(path, preview, inspection);
      break;
    case FileKind::kBtf:
      inspectBtf(path, preview, inspection);
      break;
    case FileKind::kRtt:
      inspectRtt(path, preview, inspection);
      break;
  }
  if (inspection.preview)
    inspection.summary.sections.push_back({"preview", {{"shows", inspection.preview->caption, ""}}, {}, {}});
  return inspection;
}

}  // namespace bakelight::inspect
