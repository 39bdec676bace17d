#include "tools/player/techniques/texel_response.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>

#include "formats/error.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/gl/gl_program.h"
#include "tools/player/gl/gpu_timer.h"
#include "transport/translucent_tables.h"

namespace bakelight::player {
namespace {

using formats::Translucency;
using formats::wordsOf;

enum Uniform : GLint { kFirst, kCount, kSide, kHasOthers };  // of all four shaders

constexpr int kMargin = formats::kKernelSide / 2;

const Translucency& translucencyOf(const formats::Pack& pack) {
  const Translucency& translucency = *pack.appearances.at(0).reflection.as<Translucency>();
  transport::requireFit(translucency);
  return translucency;
}

template <class T>
Buffer bufferOf(std::span<const T> values) {
  return makeBuffer(values.size_bytes(), values.data());
}
template <class T>
Buffer bufferOf(const std::vector<T>& values) {
  return bufferOf(std::span<const T>(values));
}

Buffer colors(std::size_t count) {
  return makeBuffer(count * sizeof(formats::Float4), nullptr);
}

// Of the three knots of each texel the first vertex there.
std::vector<std::uint32_t> verticesOf(const Translucency& translucency) {
  std::vector<std::uint32_t> vertex(static_cast<std::size_t>(translucency.knot_count), 0);
  for (std::size_t v = translucency.knots.size(); v-- > 0;)
    vertex[translucency.knots[v]] = static_cast<std::uint32_t>(v);
  std::vector<std::uint32_t> vertices;
  for (const std::uint32_t knot : wordsOf(translucency.texel_knots)) vertices.push_back(vertex[knot]);
  return vertices;
}

// Texel, and in halves power and blend: knot_gather.comp.
Buffer giftBuffer(const transport::Gifts& gifts) {
  std::vector<float> values;
  for (const transport::Gift& gift : gifts.gifts)
    values.insert(values.end(), {gift.power, gift.blend[0], gift.blend[1], gift.blend[2]});
  const formats::EncodedTable halves =
      formats::encodeTable(values, 4, formats::Precision::kFloat16, "", "what texels give to knots");
  std::vector<std::array<std::uint32_t, 3>> packed(gifts.gifts.size());
  for (std::size_t g = 0; g < packed.size(); ++g) {
    packed[g][0] = gifts.gifts[g].texel;
    std::memcpy(&packed[g][1], halves.data.data() + g * halves.rowBytes(), halves.rowBytes());
  }
  return bufferOf(packed);
}

formats::EncodedTable halfKernels(const Translucency& translucency) {
  if (translucency.components == 0) return translucency.kernels;
  return formats::encodeTable(transport::expandedKernels(translucency),
                              std::size_t{3} * formats::kKernelTexels, formats::Precision::kFloat16, "",
                              "kernels of texels");
}

Texture blackTexture(int side) {
  Texture texture = makeTexture(GL_RGBA32F, side, side);
  const formats::Float4 nothing{};
  glClearTexImage(texture.name(), 0, GL_RGBA, GL_FLOAT, nothing.data());
  return texture;
}

void bind(GLuint first_binding, std::initializer_list<const Buffer*> buffers) {
  for (const Buffer* buffer : buffers)
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, first_binding++, buffer->name());
}

void dispatch(const RowRange& range) {
  glUniform1ui(kFirst, static_cast<GLuint>(range.first));
  glUniform1ui(kCount, static_cast<GLuint>(range.count));
  dispatchItems(range.count);
}

const std::string kDefinitions = "#define SIDE " + std::to_string(formats::kKernelSide) +
                                 "\n#define MARGIN " + std::to_string(kMargin) + "\n";

}  // namespace

TexelResponse::TexelResponse(const formats::Pack& pack, std::size_t largest_block_bytes)
    : side_(translucencyOf(pack).resolution),
      texel_count_(translucencyOf(pack).texelCount()),
      receiver_count_(translucencyOf(pack).receiverCount()),
      weights_(translucencyOf(pack).texel_weights),
      kernels_(halfKernels(translucencyOf(pack))),
      sharpen_transposed_(transport::transposed(translucencyOf(pack).sharpen,
                                                static_cast<std::size_t>(translucencyOf(pack).knot_count)),
                          largest_block_bytes),
      near_factors_(translucencyOf(pack).near, largest_block_bytes),
      sharpen_(translucencyOf(pack).sharpen, largest_block_bytes) {
  const Translucency& t = translucencyOf(pack);
  requireRoom(t);
  const auto knots = static_cast<std::size_t>(t.knot_count), far = static_cast<std::size_t>(t.far_count);
  const transport::Gifts gifts = transport::giftsOf(t);
  vertices_ = bufferOf(verticesOf(t));
  knots_ = bufferOf(wordsOf(t.texel_knots));
  places_ = bufferOf(wordsOf(t.texels));
  receivers_ = bufferOf(wordsOf(t.receivers));
  gift_ends_ = bufferOf(gifts.ends);
  gifts_ = giftBuffer(gifts);
  entering_ = makeBuffer(texel_count_ * sizeof(formats::Float3), nullptr);
  picture_ = blackTexture(side_ + 2 * kMargin);
  radiosity_ = blackTexture(side_);
  power_ = colors(knots), at_knots_ = colors(knots), spare_ = colors(knots);
  far_ = colors(far), spare_far_ = colors(far), near_ = colors(receiver_count_);
  if (far > 0)
    far_factors_.emplace(Far{SparseProduct(transport::transposed(t.spread, far), largest_block_bytes),
                             SparseProduct(t.far, largest_block_bytes),
                             SparseProduct(t.spread, largest_block_bytes)});
  illumination_ = {
      makeComputeProgram({kTableGlsl, kTexelEnteringComp}, weights_.definitions() + kDefinitions),
      rowRanges(texel_count_, weights_.rowBytes(), 1, largest_block_bytes)};
  distribution_ = {makeComputeProgram({kKnotGatherComp}), rowRanges(knots, 1, 1)};
  filter_ = {makeComputeProgram({kTableGlsl, kTexelFilterComp}, kernels_.definitions() + kDefinitions),
             rowRanges(receiver_count_, kernels_.rowBytes(), 1, largest_block_bytes)};
  combination_ = {makeComputeProgram({kTableGlsl, kTexelCombinationComp}, weights_.definitions()),
                  rowRanges(receiver_count_, 1, 1)};
  throwIfGlFailed("uploading a translucent object");
}

// Kernels and matrices are bound in pieces; what is read in any order must fit as a whole.
void TexelResponse::requireRoom(const Translucency& t) const {
  GLint64 block = 0;
  GLint largest_side = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &block);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest_side);
  const auto fits = [&](std::size_t count, std::size_t bytes) {
    return count * bytes <= static_cast<std::size_t>(block);
  };
  // Gifts: three a texel; knots: RGB and padding.
  if (side_ + 2 * kMargin <= largest_side && fits(3 * texel_count_, 3 * sizeof(std::uint32_t)) &&
      fits(receiver_count_, sizeof(formats::Float4)) &&
      fits(static_cast<std::size_t>(t.knot_count), sizeof(formats::Float4)))
    return;
  throw Error(ExitStatus::kNotAvailable, {"", glRendererName(), ""},
              "an atlas of " + std::to_string(side_) + " texels a side with " + std::to_string(texel_count_) +
                  " in use and " + std::to_string(t.knot_count) + " knots is too large for this OpenGL",
              "storage blocks of " + std::to_string(block) + " bytes, textures of " +
                  std::to_string(largest_side) + " texels a side",
              "an atlas of fewer texels");
}

void TexelResponse::respond(const Buffer& at_vertices, const Buffer* others) {
  illuminate(at_vertices, others);
  distribute();
  multiply();
  filter();
  combine();
  throwIfGlFailed("lighting a translucent object");
}

void TexelResponse::illuminate(const Buffer& at_vertices, const Buffer* others) const {
  const GpuPass pass("illumination");
  glUseProgram(illumination_.program.name());
  glUniform1ui(kSide, static_cast<GLuint>(side_));
  glUniform1i(kHasOthers, others != nullptr ? 1 : 0);
  bind(2, {&vertices_, &at_vertices, &places_, others != nullptr ? others : &at_vertices, &entering_});
  glBindImageTexture(0, picture_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  for (const RowRange& range : illumination_.ranges) {
    weights_.bind(range);
    dispatch(range);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
}

void TexelResponse::distribute() const {
  const GpuPass pass("distribution");
  glUseProgram(distribution_.program.name());
  bind(0, {&gift_ends_, &gifts_, &entering_, &power_, &at_knots_});
  for (const RowRange& range : distribution_.ranges) dispatch(range);
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

// g = sharpen (near + spread far spreadᵀ) sharpenᵀ e + d.
void TexelResponse::multiply() const {
  const GpuPass pass("throughput");
  sharpen_transposed_.multiply(power_, spare_);
  near_factors_.multiply(spare_, power_);
  if (far_factors_) {
    far_factors_->gather.multiply(spare_, far_);
    far_factors_->factors.multiply(far_, spare_far_);
    far_factors_->spread.multiply(spare_far_, power_, true);
  }
  sharpen_.multiply(power_, at_knots_, true);
}

void TexelResponse::filter() const {
  const GpuPass pass("filter");
  glUseProgram(filter_.program.name());
  glUniform1ui(kSide, static_cast<GLuint>(side_));
  bind(2, {&receivers_, &places_, &near_});
  glBindTextureUnit(0, picture_.name());
  for (const RowRange& range : filter_.ranges) {
    kernels_.bind(range);
    dispatch(range);
  }
  glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
}

void TexelResponse::combine() const {
  const GpuPass pass("combination");
  glUseProgram(combination_.program.name());
  glUniform1ui(kSide, static_cast<GLuint>(side_));
  if (texel_count_ > 0) weights_.bind({0, texel_count_});
  bind(2, {&receivers_, &places_, &knots_, &near_, &at_knots_});
  glBindImageTexture(0, radiosity_.name(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  for (const RowRange& range : combination_.ranges) dispatch(range);
  glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

std::size_t TexelResponse::gpuBytes() const {
  std::size_t bytes = weights_.gpuBytes() + kernels_.gpuBytes() + sharpen_transposed_.gpuBytes() +
                      near_factors_.gpuBytes() + sharpen_.gpuBytes();
  if (far_factors_)
    bytes +=
        far_factors_->gather.gpuBytes() + far_factors_->factors.gpuBytes() + far_factors_->spread.gpuBytes();
  for (const Buffer* buffer : {&vertices_, &knots_, &places_, &receivers_, &gift_ends_, &gifts_, &entering_,
                               &power_, &at_knots_, &spare_, &far_, &spare_far_, &near_})
    bytes += sizeInBytes(*buffer);
  const auto texels = [](int side) {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  };
  return bytes + (texels(side_) + texels(side_ + 2 * kMargin)) * sizeof(formats::Float4);
}

}  // namespace bakelight::player
