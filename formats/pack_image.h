// A picture in a pack: raw rows, so that players need no decoder.
#pragma once

#include <string>
#include <vector>

#include "formats/encoded_table.h"

namespace bakelight::formats {

// height rows of width texels, the first row at the top; channels of a texel side by side. Precision as that
// of a table whose rows are texels: kUint8 with scale and offset of each channel.
struct PackImage {
  int width = 0, height = 0;
  std::vector<std::string> channels;  // names, "R", "G", "B": as many as the table has columns
  EncodedTable texels;
};

}  // namespace bakelight::formats
