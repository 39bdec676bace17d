#include "tools/player/techniques/patch_surface.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include "formats/error.h"
#include "formats/signed_codes.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gpu_timer.h"
#include "tools/player/gl/surface_mesh.h"
#include "transport/hemisphere_grid.h"
#include "transport/patch_lookup.h"

namespace bakelight::player {
namespace {

using formats::Float2;
using formats::Float3;
using formats::Float4;

// Groups that one draw adds up: 12 of the 16 attributes and varyings that GL guarantees.
constexpr std::size_t kGroupsAtOnce = 4;

enum Attribute : GLuint {
  kPosition = 0,
  kNormal = 1,
  kTangent = 2,
  kTexcoord = 3,
  kProjected = 4
};                      // patch_surface.vert
enum Uniform : GLint {  // both shaders
  kClipFromPosition = 0,
  kEye,
  kPixelAngle,
  kTexelWidth,
  kFirstGroup,
  kAlpha,
  kPlacing,
  kLevels,
  kStartHeight = 32,  // beyond all levels
  kFirstCreased
};

Buffer bufferOf(const auto& values) {
  return makeBuffer(values.size() * sizeof(values[0]), values.data());
}

std::vector<formats::Triangle> trianglesOf(const formats::TriangleMesh& mesh, std::size_t material) {
  if (mesh.triangle_materials.empty()) return mesh.triangles;
  std::vector<formats::Triangle> triangles;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t)
    if (mesh.triangle_materials[t] == material) triangles.push_back(mesh.triangles[t]);
  return triangles;
}

void requireRoom(int width, int height, int layers) {
  GLint largest = 0, most_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  if (std::max(width, height) <= largest && layers <= most_layers) return;
  throw badInput({"", "patch", ""},
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

PatchSurface::PatchSurface(const formats::TriangleMesh& mesh, std::span<const Float4> tangents,
                           const std::vector<SurfacePatch>& patches, const transport::Vec3& origin)
    : origin_(origin) {
  const std::size_t count = mesh.vertexCount();
  if (mesh.normals.size() != count || tangents.size() != count)
    throw std::invalid_argument("surfaces with patches need a frame a vertex");
  std::vector<Float3> positions;
  positions.reserve(count);
  for (const Float3& position : mesh.positions)
    positions.push_back(transport::float3(transport::vec3(position) - origin));
  positions_ = bufferOf(positions);
  normals_ = bufferOf(mesh.normals);
  tangents_ = bufferOf(tangents);
  texcoords_ = mesh.texcoords.empty() ? bufferOf(std::vector<Float2>(count)) : bufferOf(mesh.texcoords);
  indices_ = bufferOf(mesh.triangles);
  index_count_ = indexCountOf(mesh.triangleCount(), "mesh", "a simplified mesh");
  const formats::PackImage* last = nullptr;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const formats::FactoredPatch& source = *patches[i].patch;
    Patch patch;
    const std::vector<formats::Triangle> triangles = trianglesOf(mesh, i);
    patch.indices = bufferOf(triangles);
    patch.index_count = indexCountOf(triangles.size(), "mesh", "a simplified mesh");
    patch.views = source.views;
    patch.groups = (static_cast<std::size_t>(source.components) + kGroup - 1) / kGroup;
    // One program for all draws: as many groups in each, filled up with zeros.
    const std::size_t draws = (patch.groups + kGroupsAtOnce - 1) / kGroupsAtOnce;
    patch.groups_at_once = (patch.groups + draws - 1) / draws;
    patch.groups = draws * patch.groups_at_once;
    patch.texel_width = source.patch_width / static_cast<float>(source.width);
    patch.repeats = {source.repeats,
                     source.repeats * static_cast<float>(source.width) / static_cast<float>(source.height)};
    patch.first_creased = patches[i].first_creased;
    patch.relief = source.heights && source.views > 1;
    uploadFactors(source, patch);
    if (patch.relief) uploadRelief(source, patch);
    if (const formats::PackImage* index = patches[i].index; index != nullptr) {
      if (index != last) {
        index_images_.push_back(std::make_unique<Texture>(indexTexture(*index)));
        index_bytes_ += index->texels.data.size();
        last = index;
      }
      patch.index = index_images_.back().get();
      patch.index_decoding = {index->texels.scale[0], index->texels.scale[1], index->texels.offset[0],
                              index->texels.offset[1]};
    }
    most_groups_ = std::max(most_groups_, patch.groups);
    patches_.push_back(std::move(patch));
  }
  projected_ = makeBuffer(count * most_groups_ * 3 * sizeof(Float4), nullptr);
  for (Patch& patch : patches_) addDraws(patch);
  depth_program_ = makeProgram({{GL_VERTEX_SHADER, {kDepthVert}}, {GL_FRAGMENT_SHADER, {kDepthFrag}}});
  depth_vertices_ = makeVertexArray(indices_, {{kPosition, &positions_}});
  throwIfGlFailed("uploading patches");
}

std::vector<float> PatchSurface::basisOf(const formats::FactoredPatch& patch, std::size_t incident_values,
                                         std::size_t first_group, std::size_t groups) {
  std::vector<float> basis(incident_values * 3 * groups * kGroup, 0.0F);
  const bool is_signed = formats::isSigned(patch.factors);
  const std::size_t end =
      std::min(kGroup * (first_group + groups), static_cast<std::size_t>(patch.components));
  for (std::size_t k = kGroup * first_group; k < end; ++k) {
    // Signed bytes are looked up as −1 to 1: what 1 stands for is in the basis.
    const float unit = is_signed ? formats::kSignedMiddle * patch.factors.scale[k] : 1;
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < incident_values; ++i)
        basis[(i * 3 + c) * kGroup * groups + k - kGroup * first_group] =
            unit * patch.basis[(k * 3 + c) * incident_values + i];
  }
  return basis;
}

void PatchSurface::uploadFactors(const formats::FactoredPatch& source, Patch& patch) {
  const std::vector<formats::RttLevel> levels = formats::rttLevels(source.width, source.height);
  const std::size_t views = static_cast<std::size_t>(source.views) * source.views,
                    components = static_cast<std::size_t>(source.components);
  // The finest level, and the others in a column beside it.
  int below = 0;
  for (const formats::RttLevel& level : levels) {
    const bool finest = level.first_texel == 0;
    patch.levels.push_back({finest ? 0 : source.width, finest ? 0 : below, level.width, level.height});
    if (!finest) below += level.height;
  }
  // Side by side: a block of views a texel and a layer a group, for the hardware to filter; with relief, where each view is looked
  // up at a place of its own, the groups of a texel and a layer a view, so that one look takes what lies together.
  const bool by_view = patch.relief;
  const int groups = static_cast<int>(patch.groups);
  const int across = by_view ? groups : source.views, down = by_view ? 1 : source.views;
  const int layers = by_view ? source.views * source.views : groups;
  const int width = across * (source.width + (levels.size() > 1 ? levels[1].width : 0)),
            height = down * std::max(source.height, below);
  requireRoom(width, height, layers);
  const bool full = source.factors.precision == formats::Precision::kFloat32;
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  patch.factors = Texture(name);
  const bool is_signed = formats::isSigned(source.factors);
  glTextureStorage3D(name, 1,
                     full        ? GL_RGBA32F
                     : is_signed ? GL_RGBA8_SNORM
                                 : GL_RGBA16F,
                     width, height, layers);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(name, wrap, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(name, filter, GL_LINEAR);
  patch.texture_bytes += static_cast<std::size_t>(width) * height * layers * (full ? 16 : is_signed ? 4 : 8);

  const std::vector<float> factors = source.factors.decode();
  std::vector<float> units(components, 1.0F);
  for (std::size_t k = 0; is_signed && k < components; ++k)
    if (source.factors.scale[k] > 0) units[k] = formats::kSignedMiddle * source.factors.scale[k];
  for (int layer = 0; layer < layers; ++layer)
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const int columns = levels[l].width * across, rows = levels[l].height * down;
      std::vector<Float4> texels(static_cast<std::size_t>(columns) * rows, Float4{0, 0, 0, 0});
      for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
          const std::size_t texel =
              levels[l].first_texel + static_cast<std::size_t>(y / down) * levels[l].width + x / across;
          const std::size_t view = by_view ? layer : y % down * source.views + x % across;
          const std::size_t group = by_view ? x % across : layer;
          const float* row = &factors[(texel * views + view) * components];
          for (std::size_t k = 0; k < kGroup && group * kGroup + k < components; ++k)
            texels[static_cast<std::size_t>(y) * columns + x][k] =
                row[group * kGroup + k] / units[group * kGroup + k];
        }
      glTextureSubImage3D(name, 0, patch.levels[l][0] * across, patch.levels[l][1] * down, layer, columns,
                          rows, 1, GL_RGBA, GL_FLOAT, texels.data());
    }
}

void PatchSurface::uploadRelief(const formats::FactoredPatch& source, Patch& patch) {
  const std::vector<formats::RttLevel> levels = formats::rttLevels(source.width, source.height);
  const int side = source.views;
  const std::size_t views = static_cast<std::size_t>(side) * side;
  requireRoom(source.width, source.height, side * side);
  const std::vector<float> heights = source.heights->decode();
  patch.start_height = transport::kReliefStart * *std::max_element(heights.begin(), heights.end());
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &name);
  patch.heights = Texture(name);
  glTextureStorage3D(name, static_cast<GLsizei>(levels.size()), GL_R16F, source.width, source.height,
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
      slopes.push_back(transport::reliefSlope(transport::hemisphereCell(side, column, row),
                                              transport::leastReliefCosine(side)));
  patch.slopes = makeTexture(GL_RG32F, side, side);
  glTextureSubImage2D(patch.slopes.name(), 0, 0, 0, side, side, GL_RG, GL_FLOAT, slopes.data());
  patch.texture_bytes += heights.size() * 2 + slopes.size() * sizeof(Float2);
}

void PatchSurface::addDraws(Patch& patch) {
  std::string definitions = "#define GROUPS " + std::to_string(patch.groups_at_once) + "\n#define VIEWS " +
                            std::to_string(patch.views) + "\n#define LEVELS " +
                            std::to_string(patch.levels.size()) + "\n" +
                            (patch.index != nullptr ? "#define INDEX\n" : "");
  if (patch.first_creased) definitions += "#define CREASES\n";
  if (patch.relief)
    definitions += "#define ALL_GROUPS " + std::to_string(patch.groups) + "\n#define RELIEF_STEPS " +
                   std::to_string(transport::kReliefSteps) + "\n#define LEAST_RELIEF_COSINE " +
                   std::to_string(transport::leastReliefCosine(patch.views)) +
                   "\n#define UNSEEN_RELIEF_WEIGHT " + std::to_string(transport::kUnseenReliefWeight) + "\n";
  patch.program = makeProgram({{GL_VERTEX_SHADER, {kPatchSurfaceVert}, definitions},
                               {GL_FRAGMENT_SHADER, {kPatchSurfaceFrag}, definitions}});
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
    attribute(kPosition, positions_, 0, sizeof(Float3), 3);
    attribute(kNormal, normals_, 0, sizeof(Float3), 3);
    attribute(kTangent, tangents_, 0, sizeof(Float4), 4);
    attribute(kTexcoord, texcoords_, 0, sizeof(Float2), 2);
    for (std::size_t i = 0; i < 3 * patch.groups_at_once; ++i)
      attribute(kProjected + static_cast<GLuint>(i), projected_, (3 * first + i) * sizeof(Float4), stride, 4);
    glVertexArrayElementBuffer(name, patch.indices.name());
    patch.draws.push_back(std::move(vertices));
  }
}

void PatchSurface::lookFrom(const transport::ViewPoint& view) {
  eye_ = transport::float3(view.eye - origin_);
  pixel_angle_ = static_cast<float>(view.pixel_angle);
}

void PatchSurface::drawDepth(const Eigen::Matrix4f& clip_from_position) const {
  const GpuPass pass("depth");
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glUseProgram(depth_program_.name());
  glUniformMatrix4fv(kClipFromPosition, 1, GL_FALSE, clip_from_position.data());
  glBindVertexArray(depth_vertices_.name());
  glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void PatchSurface::draw(const Eigen::Matrix4f& clip_from_position) const {
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
    if (patch.first_creased) glUniform1i(kFirstCreased, static_cast<GLint>(*patch.first_creased));
    for (std::size_t i = 0; i < patch.draws.size(); ++i) {
      // What the first draw shows, the others add to.
      if (i == 1) glEnable(GL_BLEND);
      glUniform1i(kFirstGroup, static_cast<GLint>(i * patch.groups_at_once));
      glUniform1f(kAlpha, i == 0 ? 1.0F : 0.0F);
      glBindVertexArray(patch.draws[i].name());
      glDrawElements(GL_TRIANGLES, patch.index_count, GL_UNSIGNED_INT, nullptr);
    }
    glDisable(GL_BLEND);
  }
  glDepthFunc(GL_LEQUAL);
}

std::size_t PatchSurface::gpuBytes() const {
  std::size_t bytes = sizeInBytes(positions_) + sizeInBytes(normals_) + sizeInBytes(tangents_) +
                      sizeInBytes(texcoords_) + sizeInBytes(indices_) + sizeInBytes(projected_) +
                      index_bytes_;
  for (const Patch& patch : patches_) bytes += sizeInBytes(patch.indices) + patch.texture_bytes;
  return bytes;
}

}  // namespace bakelight::player
