// How the transfer stage meets the disk: what it accepts, the file it writes, the figures it reports.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/stage/stage.h"
#include "tools/transfer/cpca.h"
#include "tools/transfer/pixel_transfer.h"
#include "tools/transfer/transfer.h"

namespace bakelight::transfer {

// Where the local frames of matrices come from.
enum class FrameSource { kNormals, kTexcoords };

// Of matrices: whether they cut light off at each vertex's own tangent plane.
enum class Horizon { kCut, kOpen };

// What light is given in: spherical harmonics, or the texels of a cube map.
enum class Basis { kSh, kPixel };

// Whether there are transfer matrices beside the vectors, and how they are represented.
enum class Technique { kDiffuse, kGlossy };
enum class Storage { kMatrix, kVisibility, kCpca };

// The parameters as a user gives them; those of `options` that follow from others are filled in by bakeOptions.
struct TransferSettings {
  Basis basis = Basis::kSh;
  Technique technique = Technique::kDiffuse;
  Storage storage = Storage::kMatrix;  // of glossy transfer
  FrameSource frames = FrameSource::kNormals;
  Horizon horizon = Horizon::kCut;
  bool near_field = false;
  double sphere_radius = 2;
  TransferOptions options;
  CpcaOptions cpca;
  PixelOptions pixel;

  bool isGlossy() const { return technique == Technique::kGlossy; }
};

// The tool's parameters, one for each setting.
void declare(stage::Tool& tool, TransferSettings& settings);

// `settings.options` completed from the rest. Throws Error(kBadInput) at a JSON pointer for settings that
// exclude each other.
TransferOptions bakeOptions(const TransferSettings& settings);

// Throws Error(kBadInput) if the mesh has no vertex or no normals.
formats::TriangleMesh readBakeableMesh(const std::filesystem::path& path);
// Throws Error(kBadInput) where settings have no use for an original.
void requireOriginalOfUse(const TransferSettings& settings, const std::string& original_file);
// The tangents of the vertices' frames: those of `frames_path` if that is not empty (tensor "tangent", made for this
// mesh), else along texture coordinates, or none where any will do. Throws Error(kBadInput) naming file and
// tensor, or /frame for a mesh without texture coordinates; warns of vertices that these leave undetermined.
std::vector<formats::Float4> localFrames(const formats::TriangleMesh& mesh, FrameSource source,
                                         const std::filesystem::path& frames_path,
                                         const std::string& mesh_file, stage::Run& run);
// Writes the tensors and metadata that pack and inspect read (docs/FORMATS.md). `albedo` may be empty; `cpca`
// only with that storage.
void writeTransfer(const std::filesystem::path& path, const formats::TriangleMesh& mesh,
                   const TransferSettings& settings, std::span<const formats::Float3> albedo,
                   const Transfer& baked, const std::optional<Cpca>& cpca);

// Figures of the bake into `run`, and warnings where a person should look.
void report(const formats::TriangleMesh& mesh, const TransferSettings& settings, const Transfer& baked,
            const std::optional<Cpca>& cpca, double bake_s, stage::Run& run);

}  // namespace bakelight::transfer
