#include "tools/inspect/inspect.h"

#include "formats/error.h"
#include "formats/mesh_import.h"
#include "formats/mesh_ply.h"
#include "tools/inspect/describe.h"
#include "tools/inspect/file_kind.h"

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

void inspectMesh(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::MeshImport import = readMesh(path);
  inspection.summary.sections = describeMesh(import.mesh, import.notes);
  if (!options) return;
  if (options->showsTexcoords())
    inspection.preview = previewAtlas(import.mesh, *options, path.string());
  else if (options->paint == Paint::kMaterials)
    inspection.preview = previewMaterials(import.mesh, *options, path.string());
  else
    inspection.preview = previewMesh(import.mesh, *options, path.string());
}

void inspectImage(const std::filesystem::path& path, const Options& options, Inspection& inspection) {
  const formats::Image image = formats::readImage(path, formats::NonFinite::kKeep);
  const std::string ending = formats::lowerEnding(path);
  const bool display_encoded = ending != ".exr" && ending != ".hdr";
  inspection.summary.sections = describeImage(image, path.string());
  if (options) inspection.preview = previewImage(image, display_encoded, *options);
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

Inspection inspectFile(const std::filesystem::path& path, const Options& preview) {
  const FileKind kind = kindOfFile(path);
  Inspection inspection;
  inspection.summary.file = path.string();
  inspection.summary.kind = nameOf(kind);
  inspection.summary.file_bytes = std::filesystem::file_size(path);
  switch (kind) {
    case FileKind::kMesh:
      inspectMesh(path, preview, inspection);
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
  }
  if (inspection.preview)
    inspection.summary.sections.push_back({"preview", {{"shows", inspection.preview->caption, ""}}, {}, {}});
  return inspection;
}

}  // namespace bakelight::inspect
