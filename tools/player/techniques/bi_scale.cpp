#include "tools/player/techniques/bi_scale.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_table.h"
#include "tools/player/gl/gpu_timer.h"
#include "tools/player/operators/visibility_operator.h"
#include "transport/bi_scale_shading.h"
#include "transport/hemisphere_grid.h"
#include "transport/patch_table.h"
#include "transport/sh.h"

namespace bakelight::player {
namespace {

using formats::Float2;
using formats::Float3;
using formats::Float4;
using formats::RttReflection;

enum Attribute : GLuint {
  kPosition = 0,
  kNormal = 1,
  kTangent = 2,
  kTexcoord = 3,
  kProjected = 4
};                      // bi_scale.vert
enum Uniform : GLint {  // both shaders
  kClipFromPosition = 0,
  kEye,
  kPixelAngle,
  kTexelWidth,
  kFirstGroup,
  kAlpha,
  kPlacing,
  kLevels,
  kStartHeight = 32  // beyond all levels
};

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

// Groups from `first` on: coefficients × RGB × groups × 4 components; components beyond the last are zero.
Buffer basisOf(const RttReflection& reflection, std::size_t first, std::size_t groups) {
  const auto coefficients = static_cast<std::size_t>(transport::coefficientCount(reflection.order));
  std::vector<float> basis(coefficients * 3 * groups * 4, 0.0F);
  const std::size_t end = std::min(4 * (first + groups), static_cast<std::size_t>(reflection.components));
  for (std::size_t k = 4 * first; k < end; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < coefficients; ++i)
        basis[(i * 3 + c) * 4 * groups + k - 4 * first] =
            reflection.basisOf(static_cast<int>(k))[c * coefficients + i];
  return bufferOf(basis);
}

std::vector<Float3> albedos(const formats::Pack& pack, const std::vector<formats::VertexRange>& ranges) {
  std::vector<Float3> albedo(pack.mesh.vertexCount(), Float3{1, 1, 1});
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    if (pack.appearances[i].reflection.as<RttReflection>() != nullptr) continue;
    for (std::size_t v = ranges[i].first; v < ranges[i].end; ++v)
      for (std::size_t c = 0; c < 3; ++c)
        albedo[v][c] = pack.appearances[i].base_color[c] * (pack.colors.empty() ? 1 : pack.colors[v][c]);
  }
  return albedo;
}

std::vector<formats::Triangle> trianglesOf(const formats::Pack& pack, std::size_t appearance) {
  if (pack.mesh.triangle_materials.empty()) return pack.mesh.triangles;
  std::vector<formats::Triangle> triangles;
  for (std::size_t t = 0; t < pack.mesh.triangleCount(); ++t)
    if (pack.mesh.triangle_materials[t] == appearance) triangles.push_back(pack.mesh.triangles[t]);
  return triangles;
}

void requireRoom(int width, int height, int layers) {
  GLint largest = 0, most_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  if (std::max(width, height) <= largest && layers <= most_layers) return;
  throw badInput({"", "radiance transfer texture", ""},
                 "it takes " + std::to_string(layers) + " layers of " + std::to_string(width) + " × " +
                     std::to_string(height) + " texels on the GPU",
                 "at most " + std::to_string(most_layers) + " of " + std::to_string(largest) + " a side",
                 "a lower resolution, or fewer views");
}

Texture indexTexture(const formats::PackImage& image) {
  if (image.texels.columns != 2 || image.texels.precision != formats::Precision::kUint8)
    throw std::invalid_argument("an index has two channels of 8 bits");
  Texture texture = makeTexture(GL_RG8, image.width, image.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.name(), 0, 0, 0, image.width, image.height, GL_RG, GL_UNSIGNED_BYTE,
                      image.texels.data.data());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  return texture;
}

}  // namespace

bool BiScale::plays(const formats::Pack& pack) {
  return transport::BiScaleShading::shades(pack);
}

transport::LightNeeds BiScale::needs(const formats::Pack& pack) {
  return {pack.sh().order};
}

BiScale::BiScale(const formats::Pack& pack, const SurfaceMesh& mesh, bool near_light)
    : mesh_(mesh), output_order_(pack.sh().glossy.value().output_order), light_(near_light) {
  const formats::GlossyTransfer& transfer = *pack.sh().glossy;
  const std::size_t count = pack.mesh.vertexCount();
  if (pack.mesh.normals.size() != count || transfer.tangents.size() != count)
    throw std::invalid_argument("bi-scale shading needs a frame a vertex");
  transfer_ = makeTransferOperator(transfer.isInObjectFrame() ? matricesFromVisibility(pack) : pack.sh());
  const std::vector<formats::VertexRange> ranges = formats::appearanceRanges(pack);
  const std::vector<const formats::PackImage*> indices = formats::patchIndices(pack);
  normals_ = bufferOf(pack.mesh.normals);
  tangents_ = bufferOf(transfer.tangents);
  texcoords_ =
      pack.mesh.texcoords.empty() ? bufferOf(std::vector<Float2>(count)) : bufferOf(pack.mesh.texcoords);
  albedo_ = bufferOf(albedos(pack, ranges));
  const formats::PackImage* last = nullptr;
  std::vector<RttReflection> reflections;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto* own = pack.appearances[i].reflection.as<RttReflection>();
    const RttReflection reflection = own == nullptr ? transport::flatReflection(output_order_) : *own;
    if (reflection.order > output_order_)
      throw std::invalid_argument("a radiance transfer texture has more bands than the transferred radiance");
    Patch patch;
    patch.vertices = ranges[i];
    const std::vector<formats::Triangle> triangles = trianglesOf(pack, i);
    patch.indices = bufferOf(triangles);
    patch.index_count = indexCountOf(triangles.size(), "mesh", "a simplified mesh");
    patch.order = reflection.order;
    patch.views = reflection.views;
    patch.groups = (static_cast<std::size_t>(reflection.components) + kGroup - 1) / kGroup;
    // One program for all draws: as many groups in each, filled up with zeros.
    const std::size_t draws = (patch.groups + kGroupsAtOnce - 1) / kGroupsAtOnce;
    patch.groups_at_once = (patch.groups + draws - 1) / draws;
    patch.groups = draws * patch.groups_at_once;
    patch.texel_width = reflection.patch_width / static_cast<float>(reflection.width);
    patch.repeats = {reflection.repeats, reflection.repeats * static_cast<float>(reflection.width) /
                                             static_cast<float>(reflection.height)};
    patch.relief = reflection.heights && reflection.views > 1;
    uploadFactors(reflection, patch);
    if (patch.relief) uploadRelief(reflection, patch);
    if (own != nullptr && indices[i] != nullptr) {
      if (indices[i] != last) {
        index_images_.push_back(std::make_unique<Texture>(indexTexture(*indices[i])));
        index_bytes_ += indices[i]->texels.data.size();
        last = indices[i];
      }
      patch.index = index_images_.back().get();
      const auto& texels = indices[i]->texels;
      patch.index_decoding = {texels.scale[0], texels.scale[1], texels.offset[0], texels.offset[1]};
    }
    most_groups_ = std::max(most_groups_, patch.groups);
    patches_.push_back(std::move(patch));
    reflections.push_back(reflection);
  }
  projected_ = makeBuffer(count * most_groups_ * 3 * sizeof(Float4), nullptr);
  for (std::size_t i = 0; i < patches_.size(); ++i) addDraws(reflections[i], patches_[i]);
  depth_program_ = makeProgram({{GL_VERTEX_SHADER, {kDepthVert}}, {GL_FRAGMENT_SHADER, {kDepthFrag}}});
  depth_vertices_ = makeVertexArray(mesh_.indices(), {{kPosition, &mesh_.positions()}});
  throwIfGlFailed("uploading radiance transfer textures");
}

void BiScale::uploadFactors(const RttReflection& reflection, Patch& patch) {
  const std::vector<formats::RttLevel> levels = formats::rttLevels(reflection.width, reflection.height);
  const std::size_t views = static_cast<std::size_t>(reflection.views) * reflection.views,
                    components = static_cast<std::size_t>(reflection.components);
  // The finest level, and the others in a column beside it.
  int below = 0;
  for (const formats::RttLevel& level : levels) {
    const bool finest = level.first_texel == 0;
    patch.levels.push_back({finest ? 0 : reflection.width, finest ? 0 : below, level.width, level.height});
    if (!finest) below += level.height;
  }
  // Side by side: a block of views a texel and a layer a group, for the hardware to filter; with relief, where each view is looked
  // up at a place of its own, the groups of a texel and a layer a view, so that one look takes what lies together.
  const bool by_view = patch.relief;
  const int groups = static_cast<int>(patch.groups);
  const int across = by_view ? groups : reflection.views, down = by_view ? 1 : reflection.views;
  const int layers = by_view ? reflection.views * reflection.views : groups;
  const int width = across * (reflection.width + (levels.size() > 1 ? levels[1].width : 0)),
            height = down * std::max(reflection.height, below);
  requireRoom(width, height, layers);
  const bool full = reflection.factors.precision == formats::Precision::kFloat32;
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  patch.factors = Texture(name);
  glTextureStorage3D(name, 1, full ? GL_RGBA32F : GL_RGBA16F, width, height, layers);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(name, wrap, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(name, filter, GL_LINEAR);
  patch.texture_bytes += static_cast<std::size_t>(width) * height * layers * (full ? 16 : 8);

  const std::vector<float> factors = reflection.factors.decode();
  for (int layer = 0; layer < layers; ++layer)
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const int columns = levels[l].width * across, rows = levels[l].height * down;
      std::vector<Float4> texels(static_cast<std::size_t>(columns) * rows, Float4{0, 0, 0, 0});
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
          const std::size_t texel =
              levels[l].first_texel + static_cast<std::size_t>(y / down) * levels[l].width + x / across;
          const std::size_t view = by_view ? layer : y % down * reflection.views + x % across;
          const std::size_t group = by_view ? x % across : layer;
          const float* row = &factors[(texel * views + view) * components];
          for (std::size_t k = 0; k < kGroup && group * kGroup + k < components; ++k)
            texels[static_cast<std::size_t>(y) * columns + x][k] = row[group * kGroup + k];
        }
      glTextureSubImage3D(name, 0, patch.levels[l][0] * across, patch.levels[l][1] * down, layer, columns,
                          rows, 1, GL_RGBA, GL_FLOAT, texels.data());
    }
}

void BiScale::uploadRelief(const RttReflection& reflection, Patch& patch) {
  const std::vector<formats::RttLevel> levels = formats::rttLevels(reflection.width, reflection.height);
  const int side = reflection.views;
  const std::size_t views = static_cast<std::size_t>(side) * side;
  requireRoom(reflection.width, reflection.height, side * side);
  const std::vector<float> heights = reflection.heights->decode();
  patch.start_height = transport::kReliefStart * *std::max_element(heights.begin(), heights.end());
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  patch.heights = Texture(name);
  glTextureStorage3D(name, static_cast<GLsizei>(levels.size()), GL_R16F, reflection.width, reflection.height,
                     static_cast<GLsizei>(views));
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) glTextureParameteri(name, wrap, GL_REPEAT);
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const std::size_t texels = static_cast<std::size_t>(levels[l].width) * levels[l].height;
    std::vector<float> by_view(views * texels);
    for (std::size_t view = 0; view < views; ++view)
      for (std::size_t t = 0; t < texels; ++t)
        by_view[view * texels + t] = heights[(levels[l].first_texel + t) * views + view];
    glTextureSubImage3D(name, static_cast<GLint>(l), 0, 0, 0, levels[l].width, levels[l].height,
                        static_cast<GLsizei>(views), GL_RED, GL_FLOAT, by_view.data());
  }
  std::vector<Float2> slopes;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      slopes.push_back(transport::reliefSlope(transport::hemisphereCell(side, column, row)));
  patch.slopes = makeTexture(GL_RG32F, side, side);
  glTextureSubImage2D(patch.slopes.name(), 0, 0, 0, side, side, GL_RG, GL_FLOAT, slopes.data());
  patch.texture_bytes += heights.size() * 2 + slopes.size() * sizeof(Float2);
}

void BiScale::addDraws(const RttReflection& reflection, Patch& patch) {
  std::string definitions = "#define GROUPS " + std::to_string(patch.groups_at_once) + "\n";
  patch.project_program = makeComputeProgram(
      {kBiScaleProjectComp}, definitions + "#define COEFFICIENTS " +
                                 std::to_string(transport::coefficientCount(patch.order)) + "u\n");
  definitions += "#define VIEWS " + std::to_string(patch.views) + "\n#define LEVELS " +
                 std::to_string(patch.levels.size()) + "\n" +
                 (patch.index != nullptr ? "#define INDEX\n" : "");
  if (patch.relief)
    definitions += "#define ALL_GROUPS " + std::to_string(patch.groups) + "\n#define RELIEF_STEPS " +
                   std::to_string(transport::kReliefSteps) + "\n#define LEAST_RELIEF_COSINE " +
                   std::to_string(transport::kLeastReliefCosine) + "\n#define UNSEEN_RELIEF_WEIGHT " +
                   std::to_string(transport::kUnseenReliefWeight) + "\n";
  patch.program = makeProgram(
      {{GL_VERTEX_SHADER, {kBiScaleVert}, definitions}, {GL_FRAGMENT_SHADER, {kBiScaleFrag}, definitions}});
  const auto stride = static_cast<GLsizei>(most_groups_ * 3 * sizeof(Float4));
  for (std::size_t first = 0; first < patch.groups; first += patch.groups_at_once) {
    VertexArray vertices = makeVertexArray();
    const GLuint name = vertices.name();
    const auto attribute = [&](GLuint location, const Buffer& buffer, std::size_t offset, GLsizei step,
                               GLint size) {
      glVertexArrayVertexBuffer(name, location, buffer.name(), static_cast<GLintptr>(offset), step);
      glEnableVertexArrayAttrib(name, location);
      glVertexArrayAttribFormat(name, location, size, GL_FLOAT, GL_FALSE, 0);
      glVertexArrayAttribBinding(name, location, location);
    };
    attribute(kPosition, mesh_.positions(), 0, sizeof(Float3), 3);
    attribute(kNormal, normals_, 0, sizeof(Float3), 3);
    attribute(kTangent, tangents_, 0, sizeof(Float4), 4);
    attribute(kTexcoord, texcoords_, 0, sizeof(Float2), 2);
    for (std::size_t i = 0; i < 3 * patch.groups_at_once; ++i)
      attribute(kProjected + static_cast<GLuint>(i), projected_, (3 * first + i) * sizeof(Float4), stride, 4);
    glVertexArrayElementBuffer(name, patch.indices.name());
    patch.draws.push_back({basisOf(reflection, first, patch.groups_at_once), std::move(vertices)});
  }
}

void BiScale::setLight(const GpuLight& distant, const GpuLight* near) {
  if (!light_.update(distant, near)) return;
  {
    const GpuPass pass("transfer");
    transfer_->evaluate(light_.sh());
    throwIfGlFailed("transferring the light");
  }
  project();
}

void BiScale::project() {
  const GpuPass pass("project");
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
  const std::size_t transferred_bytes =
      static_cast<std::size_t>(transport::coefficientCount(output_order_)) * sizeof(Float3);
  const std::size_t projected_bytes = most_groups_ * 3 * sizeof(Float4);
  const std::vector<RowRange> ranges =
      rowRanges(mesh_.vertexCount(), std::max(transferred_bytes, projected_bytes), 1);
  for (const Patch& patch : patches_) {
    glUseProgram(patch.project_program.name());
    glUniform1ui(3, static_cast<GLuint>(most_groups_));
    glUniform1ui(4, static_cast<GLuint>(transport::coefficientCount(output_order_)));
    for (const RowRange& range : ranges) {
      const std::size_t first = std::max(range.first, patch.vertices.first);
      const std::size_t end = std::min(range.first + range.count, patch.vertices.end);
      if (first >= end) continue;
      bindRows(0, transfer_->transferred(), range, transferred_bytes);
      bindRows(2, albedo_, range, sizeof(Float3));
      bindRows(3, projected_, range, projected_bytes);
      glUniform1ui(0, static_cast<GLuint>(end - range.first));
      glUniform1ui(1, static_cast<GLuint>(first - range.first));
      for (std::size_t i = 0; i < patch.draws.size(); ++i) {
        glUniform1ui(2, static_cast<GLuint>(i * patch.groups_at_once));
        glBindBufferBase(GL_UNIFORM_BUFFER, 1, patch.draws[i].basis.name());
        dispatchItems(end - first);
      }
    }
  }
  glMemoryBarrier(GL_VERTEX_ATTRIB_ARRAY_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
  throwIfGlFailed("projecting onto radiance transfer textures");
}

void BiScale::lookFrom(const transport::ViewPoint& view) {
  eye_ = transport::float3(view.eye - mesh_.origin());
  pixel_angle_ = static_cast<float>(view.pixel_angle);
}

void BiScale::drawDepth(const Eigen::Matrix4f& clip_from_position) const {
  const GpuPass pass("depth");
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glUseProgram(depth_program_.name());
  glUniformMatrix4fv(kClipFromPosition, 1, GL_FALSE, clip_from_position.data());
  glBindVertexArray(depth_vertices_.name());
  glDrawElements(GL_TRIANGLES, mesh_.indexCount(), GL_UNSIGNED_INT, nullptr);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void BiScale::draw(const Eigen::Matrix4f& clip_from_position) const {
  // Looking textures up is what costs: only what is seen does it.
  drawDepth(clip_from_position);
  const GpuPass pass("surface");
  glDepthFunc(GL_EQUAL);
  glBlendFunc(GL_ONE, GL_ONE);
  for (const Patch& patch : patches_) {
    glUseProgram(patch.program.name());
    glUniformMatrix4fv(kClipFromPosition, 1, GL_FALSE, clip_from_position.data());
    glUniform3fv(kEye, 1, eye_.data());
    glUniform1f(kPixelAngle, pixel_angle_);
    glUniform1f(kTexelWidth, patch.texel_width);
    glUniform4iv(kLevels, static_cast<GLsizei>(patch.levels.size()), patch.levels.front().data());
    glBindTextureUnit(0, patch.factors.name());
    if (patch.index != nullptr) {
      glBindTextureUnit(1, patch.index->name());
      glUniform4fv(kPlacing, 1, patch.index_decoding.data());
    } else {
      glUniform2fv(kPlacing, 1, patch.repeats.data());
    }
    if (patch.relief) {
      glBindTextureUnit(2, patch.heights.name());
      glBindTextureUnit(3, patch.slopes.name());
      glUniform1f(kStartHeight, patch.start_height);
    }
    for (std::size_t i = 0; i < patch.draws.size(); ++i) {
      // What the first draw shows, the others add to.
      if (i == 1) glEnable(GL_BLEND);
      glUniform1i(kFirstGroup, static_cast<GLint>(i * patch.groups_at_once));
      glUniform1f(kAlpha, i == 0 ? 1.0F : 0.0F);
      glBindVertexArray(patch.draws[i].vertices.name());
      glDrawElements(GL_TRIANGLES, patch.index_count, GL_UNSIGNED_INT, nullptr);
    }
    glDisable(GL_BLEND);
  }
  glDepthFunc(GL_LEQUAL);
}

std::size_t BiScale::gpuBytes() const {
  std::size_t bytes = transfer_->gpuBytes() + light_.gpuBytes() + sizeInBytes(normals_) +
                      sizeInBytes(tangents_) + sizeInBytes(texcoords_) + sizeInBytes(albedo_) +
                      sizeInBytes(projected_) + index_bytes_;
  for (const Patch& patch : patches_) bytes += sizeInBytes(patch.indices) + patch.texture_bytes;
  return bytes;
}

}  // namespace bakelight::player
