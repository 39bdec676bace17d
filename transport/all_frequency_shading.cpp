#include "transport/all_frequency_shading.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "transport/cube_map.h"
#include "transport/hemisphere_grid.h"
#include "transport/patch_lookup.h"

namespace bakelight::transport {

using formats::BtfReflection;

formats::BtfReflection flatBtf(int lights) {
  BtfReflection flat;
  flat.lights = lights;
  flat.views = flat.width = flat.height = flat.components = 1;
  flat.patch_width = 1;
  flat.factors = formats::encodeTable(std::array{1.0F}, 1, formats::Precision::kFloat32, "", "flat");
  for (int color = 0; color < 3; ++color)
    for (int row = 0; row < lights; ++row)
      for (int column = 0; column < lights; ++column)
        flat.basis.push_back(
            static_cast<float>(hemisphereCellCosine(lights, column, row) / std::numbers::pi));
  return flat;
}

std::vector<Float3> texelLight(std::span<const Float3> radiance, int cube_side, int subsamples) {
  std::vector<Float3> light(radiance.size());
  for (std::size_t i = 0; i < light.size(); ++i) {
    const auto within = static_cast<int>(i) % (cube_side * cube_side);
    const double weight = cubeTexelSolidAngle(within % cube_side, within / cube_side, cube_side) /
                          (static_cast<double>(subsamples) * subsamples);
    for (std::size_t c = 0; c < 3; ++c) light[i][c] = static_cast<float>(radiance[i][c] * weight);
  }
  return light;
}

std::vector<std::uint8_t> creasedTriangles(const formats::TriangleMesh& mesh,
                                           std::span<const formats::Float4> tangents,
                                           double crease_angle_deg) {
  const double least_cosine = std::cos(crease_angle_deg * std::numbers::pi / 180);
  std::vector<std::uint8_t> creased(mesh.triangleCount(), 0);
  const auto tangentOf = [&](std::uint32_t v) {
    return Vec3(tangents[v][0], tangents[v][1], tangents[v][2]);
  };
  for (std::size_t t = 0; t < creased.size(); ++t)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t a = mesh.triangles[t][corner], b = mesh.triangles[t][(corner + 1) % 3];
      const double cosine =
          std::min(vec3(mesh.normals[a]).dot(vec3(mesh.normals[b])), tangentOf(a).dot(tangentOf(b)));
      if (cosine < least_cosine - 1e-6 || tangents[a][3] != tangents[b][3]) creased[t] = 1;
    }
  return creased;
}

struct AllFrequencyShading::Patch {
  PatchLookup lookup;
  std::vector<float> basis;  // components × 3 × cells

  Patch(const BtfReflection& btf, const formats::PackImage* index) : lookup(btf, index), basis(btf.basis) {
    if (basis.size() != lookup.components() * 3 * btf.cells())
      throw std::invalid_argument("the basis of a BTF does not fit its size");
  }
};

bool AllFrequencyShading::shades(const formats::Pack& pack) {
  return pack.transfer.as<formats::PixelTransfer>() != nullptr &&
         std::all_of(pack.appearances.begin(), pack.appearances.end(), [](const formats::Appearance& a) {
           return a.reflection.as<BtfReflection>() != nullptr ||
                  a.reflection.as<formats::LambertReflection>() != nullptr;
         });
}

namespace {

const formats::PixelTransfer& pixelTransfer(const formats::Pack& pack) {
  const auto* transfer = pack.transfer.as<formats::PixelTransfer>();
  if (transfer == nullptr) throw std::invalid_argument("the pack's transfer is not in a pixel basis");
  return *transfer;
}

}  // namespace

AllFrequencyShading::AllFrequencyShading(const formats::Pack& pack)
    : mesh_(pack.mesh),
      cube_side_(pixelTransfer(pack).cube_side),
      subsamples_(pixelTransfer(pack).subsamples),
      cells_(pixelTransfer(pack).cells()),
      tangents_(pixelTransfer(pack).tangents),
      blocks_(pixelTransfer(pack).blocks),
      ranges_(formats::appearanceRanges(pack)),
      vertex_albedo_(pack.mesh.vertexCount(), Float3{1, 1, 1}) {
  const formats::PixelTransfer& transfer = pixelTransfer(pack);
  const std::size_t vertices = mesh_.vertexCount(), block_count = transfer.blockCount();
  if (tangents_.size() != vertices || mesh_.normals.size() != vertices || blocks_.size() != vertices ||
      std::any_of(blocks_.begin(), blocks_.end(), [&](std::uint32_t block) { return block >= block_count; }))
    throw std::invalid_argument("all-frequency shading needs a frame and a block of rows for each vertex");
  if (transfer.sums) {
    sums_ = transfer.sums->grammar;
    if (sums_ == nullptr || sums_->row_count != block_count * cells_ ||
        sums_->columnCount() != transfer.texels() || sums_->subsamples != subsamples_)
      throw std::invalid_argument("the sums of transfer in a pixel basis are not those of its sizes");
    value_places_ = valuePlaces(*sums_);
    values_.assign(sums_->row_places.size(), Radiance4::Zero());
  } else {
    rows_.emplace(transfer);
    light_.assign(transfer.texels(), Float3{0, 0, 0});
  }
  const std::vector<const formats::PackImage*> indices = formats::patchIndices(pack);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const formats::Appearance& appearance = pack.appearances[i];
    const auto* btf = appearance.reflection.as<BtfReflection>();
    if (btf != nullptr && btf->lights != transfer.local_side)
      throw std::invalid_argument("a BTF has another grid of lights than the transfer's hemispheres");
    if (btf != nullptr && mesh_.texcoords.size() != vertices)
      throw std::invalid_argument("BTFs need texture coordinates");
    patches_.push_back(btf != nullptr ? std::make_shared<Patch>(*btf, indices[i])
                                      : std::make_shared<Patch>(flatBtf(transfer.local_side), nullptr));
    components_ = std::max(components_, patches_.back()->lookup.components());
    if (btf != nullptr) continue;
    for (std::size_t v = ranges_[i].first; v < ranges_[i].end; ++v)
      for (std::size_t c = 0; c < 3; ++c)
        vertex_albedo_[v][c] = appearance.base_color[c] * (pack.colors.empty() ? 1 : pack.colors[v][c]);
  }
  projected_.assign(vertices * components_, Float3{0, 0, 0});
  creased_ = creasedTriangles(mesh_, tangents_, transfer.crease_angle);
}

LightNeeds AllFrequencyShading::needs() const {
  // One band tells how bright the light is, for exposure.
  LightNeeds needs{1};
  needs.cube_side = cube_side_;
  return needs;
}

void AllFrequencyShading::setLight(std::span<const Float3>, std::span<const Float3>) {
  throw std::logic_error("all-frequency shading takes its light as a cube map");
}

std::vector<Float3> AllFrequencyShading::incident(std::size_t vertex) const {
  std::vector<Float3> cells(cells_);
  rows_ ? incidentFromRows(blocks_[vertex], cells) : incidentFromSums(blocks_[vertex], cells);
  return cells;
}

void AllFrequencyShading::incidentFromRows(std::size_t block, std::span<Float3> cells) const {
  const formats::PixelCodes codes = rows_->view();
  const std::size_t first_row = block * cells_;
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    std::array<double, 3> sum = {};
    for (std::uint64_t i = codes.row_offsets[first_row + cell]; i < codes.row_offsets[first_row + cell + 1];
         ++i) {
      const Float3& light = light_[codes.columns[i]];
      for (std::size_t c = 0; c < 3; ++c) sum[c] += double{light[c]} * codes.codes[i];
    }
    for (std::size_t c = 0; c < 3; ++c) cells[cell][c] = static_cast<float>(sum[c]);
  }
}

void AllFrequencyShading::incidentFromSums(std::size_t block, std::span<Float3> cells) const {
  for (std::size_t cell = 0; cell < cells_; ++cell) {
    const std::uint32_t place = value_places_[block * cells_ + cell];
    cells[cell] =
        place == kNoValue ? Float3{0, 0, 0} : Float3{values_[place][0], values_[place][1], values_[place][2]};
  }
}

// `falling_on(v)`: radiance × solid angle on each cell of vertex v.
template <class FallingOn>
void AllFrequencyShading::project(FallingOn falling_on) {
  for (std::size_t a = 0; a < ranges_.size(); ++a)
    tbb::parallel_for(ranges_[a].first, ranges_[a].end, [&](std::size_t v) {
      const std::vector<Float3> falling = falling_on(v);
      const Patch& patch = *patches_[a];
      for (std::size_t k = 0; k < patch.lookup.components(); ++k)
        for (std::size_t c = 0; c < 3; ++c) {
          const float* basis = &patch.basis[(3 * k + c) * cells_];
          double product = 0;
          for (std::size_t j = 0; j < cells_; ++j) product += double{basis[j]} * falling[j][c];
          projected_[v * components_ + k][c] = static_cast<float>(product) * vertex_albedo_[v][c];
        }
    });
}

void AllFrequencyShading::setCubeLight(std::span<const Float3> radiance) {
  const std::size_t texels = 6 * static_cast<std::size_t>(cube_side_) * cube_side_;
  if (radiance.size() != texels)
    throw std::invalid_argument("the light has another number of texels than the pack's transfer");
  if (sums_ != nullptr) {
    const std::vector<Float3> whole = texelLight(radiance, cube_side_, 1);
    std::vector<Radiance4> light(texels);
    for (std::size_t k = 0; k < texels; ++k) light[k] = Radiance4(whole[k][0], whole[k][1], whole[k][2], 0);
    multiply(*sums_, light, values_);
  } else {
    light_ = texelLight(radiance, cube_side_, subsamples_);
  }
  project([&](std::size_t v) { return incident(v); });
}

void AllFrequencyShading::setIncident(std::span<const Radiance4> rows) {
  const std::size_t count = sums_ != nullptr ? value_places_.size() : rows_->view().rowCount();
  if (rows.size() != count)
    throw std::invalid_argument("incident light has another number of rows than the pack's transfer");
  project([&](std::size_t v) {
    std::vector<Float3> falling(cells_);
    for (std::size_t j = 0; j < cells_; ++j) {
      const Radiance4& row = rows[blocks_[v] * cells_ + j];
      falling[j] = {row[0], row[1], row[2]};
    }
    return falling;
  });
}

std::array<float, 3> AllFrequencyShading::frameWeights(const SurfaceHit& hit) const {
  const std::array<float, 3> weights = cornerWeights(hit);
  if (creased_[hit.triangle] == 0) return weights;
  std::array<float, 3> nearest = {0, 0, 0};
  nearest[static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin())] = 1;
  return nearest;
}

Float3 AllFrequencyShading::radianceAt(const SurfaceHit& hit) const {
  const std::array<float, 3> weights = frameWeights(hit);
  const SeenPoint at = seenPoint(mesh_, tangents_, hit, weights, view_.eye);
  const PatchLookup& patch = patches_[at.appearance]->lookup;
  std::array<float, 1024> buffer;
  const std::span<float> factors = std::span(buffer).first(patch.components());
  patch.factorsAt(at, view_.pixel_angle, factors);
  Float3 radiance = {0, 0, 0};
  for (std::size_t k = 0; k < factors.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      float incident = 0;
      for (std::size_t corner = 0; corner < 3; ++corner)
        incident += weights[corner] * projected_[at.corners[corner] * components_ + k][c];
      radiance[c] += factors[k] * incident;
    }
  return radiance;
}

void AllFrequencyShading::radianceAt(std::span<const SurfaceHit> hits, std::span<Float3> radiance) const {
  for (std::size_t i = 0; i < hits.size(); ++i) radiance[i] = radianceAt(hits[i]);
}

}  // namespace bakelight::transport
