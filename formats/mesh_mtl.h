// Material libraries of OBJ files (.mtl), as far as they say what albedo a material has: Kd and map_Kd.
// Private to the importers. Source: Alias|Wavefront, "Advanced Visualizer" manual, appendix B1 and MTL
// format.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/triangle_mesh.h"

namespace bakelight::formats {

struct MtlTexture {
  std::string name;                        // as it stands there: relative to the library's folder, if to any
  std::uint64_t line = 0;                  // of the library
  Float2 scale = {1, 1}, offset = {0, 0};  // looked up at coordinates × scale + offset (-s, -o)
  bool clamp = false;                      // -clamp on
  bool operator==(const MtlTexture&) const = default;
};

struct MtlMaterial {
  std::string name;
  std::optional<Float3> color;  // Kd, as it is; none if the library does not say
  std::optional<MtlTexture> texture;
};

struct MtlFile {
  std::vector<MtlMaterial> materials;  // in the file's order; of several with one name the first counts
  std::vector<std::string> notes;      // what was not understood, each naming `file` and line
};

// Keywords in capitals or not. Kd black under a map_Kd means that the map alone counts, as exporters write
// it. Throws Error(kBadInput) naming `file` and line where Kd has no numbers or map_Kd no file.
MtlFile readMtl(std::string_view text, const std::string& file);

}  // namespace bakelight::formats
