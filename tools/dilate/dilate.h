// Fills the texels that no chart covers, so that filtering at the edges of charts does not read emptiness.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/words.h"

namespace bakelight::dilate {

enum class Method {
  // The whole texel of the nearest covered one; of equally near ones the leftmost, of these the topmost. For
  // indices, too, as nothing is averaged. With gutters of two texels or more, bilinear filtering of a point
  // in a chart reads that chart only.
  kNearest,
  // Smooth, by a pyramid of averages (Gortler et al. 1996, "The Lumigraph", section 3.4.2). Far from charts
  // it mixes them. For colours, and for mip maps.
  kPushPull
};
inline constexpr formats::Word<Method> kMethods[] = {{"nearest", Method::kNearest},
                                                     {"push_pull", Method::kPushPull}};

struct DilateOptions {
  Method method = Method::kNearest;
  int reach = 0;  // texels, from centre to centre: those further away stay as they are; 0: all are filled
};

// Texels whose channel "coverage" is not 0, one byte each. Throws Error(kBadInput) naming `file`: no such
// channel, none covered.
std::vector<std::uint8_t> coveredTexels(const formats::Image& maps, const std::string& file);

struct Dilation {
  formats::Image image;  // covered texels keep their bits
  std::int64_t filled = 0;
};

// `covered` has one byte a texel, 0 where there is a hole; one at least is not. Exact distances (Meijster et
// al. 2000). Cost: O(texels · channels); threads by TBB, same bits for any number. Throws std::logic_error if
// the sizes differ.
Dilation dilated(formats::Image image, std::span<const std::uint8_t> covered, const DilateOptions& options);

}  // namespace bakelight::dilate
