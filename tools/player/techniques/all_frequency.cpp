#include "tools/player/techniques/all_frequency.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "formats/btf_reflection.h"
#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/all_frequency_shading.h"

namespace bakelight::player {
namespace {

using formats::BtfReflection;
using formats::Float3;
using formats::Float4;

// The mesh as it is drawn: triangles across creases thrice, for each corner with its frame and light (PatchSurface).
struct DrawnMesh {
  formats::TriangleMesh mesh;
  std::vector<Float4> tangents;
  std::vector<std::uint32_t> blocks;
  std::vector<Float3> albedo;
  std::vector<formats::VertexRange> ranges;  // by appearance
  std::vector<std::size_t>
      first_creased;  // by appearance: vertices from there on are those of such triangles
};

class MeshDrawer {
 public:
  MeshDrawer(const formats::Pack& pack, const formats::PixelTransfer& transfer)
      : pack_(pack),
        transfer_(transfer),
        creased_(transport::creasedTriangles(pack.mesh, transfer.tangents, transfer.crease_angle)) {}

  DrawnMesh drawn() {
    const std::vector<formats::VertexRange> ranges = formats::appearanceRanges(pack_);
    for (std::size_t a = 0; a < ranges.size(); ++a) {
      const std::size_t first = drawn_.mesh.positions.size();
      const bool lambert = pack_.appearances[a].reflection.as<BtfReflection>() == nullptr;
      appearance_albedo_ = lambert ? pack_.appearances[a].base_color : Float3{1, 1, 1};
      colored_ = lambert && !pack_.colors.empty();
      for (std::size_t v = ranges[a].first; v < ranges[a].end; ++v) add(static_cast<std::uint32_t>(v), v);
      drawn_.first_creased.push_back(drawn_.mesh.positions.size());
      for (std::size_t t = 0; t < pack_.mesh.triangleCount(); ++t) {
        const auto material = pack_.mesh.triangle_materials.empty() ? 0 : pack_.mesh.triangle_materials[t];
        if (material != a) continue;
        const auto moved = static_cast<std::uint32_t>(first - ranges[a].first);
        const auto& [i, j, k] = pack_.mesh.triangles[t];
        if (creased_[t] != 0)
          addThrice(pack_.mesh.triangles[t], static_cast<std::uint32_t>(a));
        else
          addTriangle({i + moved, j + moved, k + moved}, static_cast<std::uint32_t>(a));
      }
      drawn_.ranges.push_back({first, drawn_.mesh.positions.size()});
    }
    return std::move(drawn_);
  }

 private:
  void addTriangle(const formats::Triangle& corners, std::uint32_t appearance) {
    drawn_.mesh.triangles.push_back(corners);
    drawn_.mesh.triangle_materials.push_back(appearance);
  }

  // A vertex where `place` is, with the frame and light of `corner`.
  std::uint32_t add(std::uint32_t corner, std::size_t place) {
    drawn_.mesh.positions.push_back(pack_.mesh.positions[place]);
    drawn_.mesh.normals.push_back(pack_.mesh.normals[corner]);
    drawn_.mesh.texcoords.push_back(pack_.mesh.texcoords.empty() ? formats::Float2{0, 0}
                                                                 : pack_.mesh.texcoords[place]);
    drawn_.tangents.push_back(transfer_.tangents[corner]);
    drawn_.blocks.push_back(transfer_.blocks[corner]);
    Float3 albedo = appearance_albedo_;
    for (std::size_t c = 0; c < 3 && colored_; ++c) albedo[c] *= pack_.colors[corner][c];
    drawn_.albedo.push_back(albedo);
    return static_cast<std::uint32_t>(drawn_.mesh.positions.size() - 1);
  }

  void addThrice(const formats::Triangle& corners, std::uint32_t appearance) {
    for (const std::uint32_t corner : corners) {
      formats::Triangle copy;
      for (std::size_t k = 0; k < 3; ++k) copy[k] = add(corner, corners[k]);
      addTriangle(copy, appearance);
    }
  }

  const formats::Pack& pack_;
  const formats::PixelTransfer& transfer_;
  std::vector<std::uint8_t> creased_;
  DrawnMesh drawn_;
  Float3 appearance_albedo_ = {1, 1, 1};
  bool colored_ = false;
};

const formats::PixelTransfer& transferOf(const formats::Pack& pack) {
  const auto* transfer = pack.transfer.as<formats::PixelTransfer>();
  if (transfer == nullptr) throw std::invalid_argument("the pack's transfer is not in a pixel basis");
  return *transfer;
}

}  // namespace

bool AllFrequency::plays(const formats::Pack& pack) {
  return transport::AllFrequencyShading::shades(pack);
}

transport::LightNeeds AllFrequency::needs(const formats::Pack& pack) {
  transport::LightNeeds needs{1};
  needs.cube_side = transferOf(pack).cube_side;
  return needs;
}

AllFrequency::AllFrequency(const formats::Pack& pack, const SurfaceMesh& mesh)
    : cube_side_(transferOf(pack).cube_side),
      subsamples_(transferOf(pack).subsamples),
      cells_(transferOf(pack).cells()) {
  const formats::PixelTransfer& transfer = transferOf(pack);
  product_ = makePixelProduct(transfer);
  light_ = makeBuffer(transfer.texels() * sizeof(Float3), nullptr, GL_DYNAMIC_STORAGE_BIT);
  GLint64 largest = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &largest);
  const std::size_t incident_bytes = transfer.blockCount() * cells_ * sizeof(Float3);
  if (incident_bytes > static_cast<std::size_t>(largest))
    throw badInput({"", "pixel transfer", ""},
                   "incident light of its vertices takes " + std::to_string(incident_bytes >> 20) + " MiB",
                   "at most " + std::to_string(largest >> 20) + " on this GPU",
                   "a simplified mesh, or fewer cells");
  incident_ = makeBuffer(incident_bytes, nullptr);
  glClearNamedBufferData(incident_.name(), GL_R32F, GL_RED, GL_FLOAT, nullptr);  // rows without an entry

  const std::vector<const formats::PackImage*> indices = formats::patchIndices(pack);
  const BtfReflection flat = transport::flatBtf(transfer.local_side);
  const DrawnMesh drawn = MeshDrawer(pack, transfer).drawn();
  std::vector<SurfacePatch> patches;
  for (std::size_t a = 0; a < pack.appearances.size(); ++a) {
    const auto* btf = pack.appearances[a].reflection.as<BtfReflection>();
    if (btf != nullptr && btf->lights != transfer.local_side)
      throw std::invalid_argument("a BTF has another grid of lights than the transfer's hemispheres");
    patches.push_back(btf != nullptr ? SurfacePatch{btf, indices[a]} : SurfacePatch{&flat, nullptr});
    if (drawn.first_creased[a] < drawn.ranges[a].end) patches.back().first_creased = drawn.first_creased[a];
  }
  surface_ = std::make_unique<PatchSurface>(drawn.mesh, drawn.tangents, patches, mesh.origin());
  std::vector<ProjectedPatch> projected;
  for (std::size_t a = 0; a < patches.size(); ++a)
    projected.push_back({patches[a].patch, drawn.ranges[a], cells_});
  projection_ = std::make_unique<PatchProjection>(*surface_, projected, drawn.albedo, cells_, drawn.blocks);
  throwIfGlFailed("uploading transfer in a pixel basis");
}

void AllFrequency::setLight(const GpuLight&, const GpuLight*) {
  throw std::logic_error("all-frequency shading takes its light as a cube map");
}

void AllFrequency::setCubeLight(std::span<const Float3> radiance) {
  const std::vector<Float3> light = transport::texelLight(radiance, cube_side_, subsamples_);
  glNamedBufferSubData(light_.name(), 0, static_cast<GLsizeiptr>(light.size() * sizeof(Float3)),
                       light.data());
  transfer();
  projection_->run(incident_);
}

void AllFrequency::transfer() {
  const GpuPass pass("transfer");
  product_->run(light_, incident_);
  throwIfGlFailed("transferring the light");
}

void AllFrequency::lookFrom(const transport::ViewPoint& view) {
  surface_->lookFrom(view);
}

void AllFrequency::draw(const Eigen::Matrix4f& clip_from_position) const {
  surface_->draw(clip_from_position);
}

std::size_t AllFrequency::gpuBytes() const {
  return product_->gpuBytes() + sizeInBytes(light_) + sizeInBytes(incident_) + projection_->gpuBytes() +
         surface_->gpuBytes();
}

}  // namespace bakelight::player
