// BTFs of the patches of several materials in one file (safetensors), in the directional basis that transfer in a pixel basis has: towards
// the middles of a grid of views, of light from the cells of a grid (transport/hemisphere_grid.h), cosines inside. What rtt and btf hand to pack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/tensor_writer.h"
#include "formats/tensors.h"

namespace bakelight::formats {

struct BtfTableShape {
  std::string material;       // "" the asset's own
  int views = 8, lights = 8;  // sides of the grids
  int width = 0, height = 0;  // texels, rows from the top

  std::size_t cells() const { return static_cast<std::size_t>(lights) * lights; }
  std::size_t valueCount() const {
    return static_cast<std::size_t>(views) * views * width * height * 3 * cells();
  }
};

// [view][texel][color][cell]: the mean over the cell of what leaves under a directional light of unit irradiance normal to itself.
struct BtfTable : BtfTableShape {
  std::string file;  // for messages
  Tensor halves;     // views² × height × width × 3 × lights²; points into the file

  // Those towards one view: width · height · 3 · cells().
  std::vector<float> valuesOf(std::size_t view) const;
};

// Tensors are called btf/NAME, that of the asset's own material btf. Throws Error(kBadInput) naming file and tensor for another type or
// shape, or a value that is not finite; for a file without any.
std::vector<BtfTable> readBtfTables(const std::filesystem::path& path);

class BtfTableWriter {
 public:
  // Throws as TensorWriter.
  BtfTableWriter(const std::filesystem::path& path, const std::vector<BtfTableShape>& shapes);
  // The next values of a material's, any number of them, in their order. Throws Error(kBadInput) if one is none of a half float.
  void append(const std::string& material, std::span<const float> values);
  void append(const BtfTable& table);  // all of it
  void finish() { writer_.finish(); }

 private:
  std::string file_;
  TensorWriter writer_;
};

}  // namespace bakelight::formats
