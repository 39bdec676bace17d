// What is in a measured BTF.
#pragma once

#include <vector>

#include "formats/btf.h"
#include "tools/inspect/preview.h"
#include "tools/inspect/summary.h"

namespace bakelight::inspect {

// A few pictures: those of the directions nearest to four views, one below the other, and four lights, side by side; decoded
// once for figures and preview.
struct BtfSheet {
  struct Picture {
    int view, light;
    formats::Image image;  // R, G, B, linear; empty where there is none
  };
  static constexpr int kColumns = 4;
  std::vector<Picture> pictures;  // row by row
};
BtfSheet sheetOf(const formats::Btf& btf);

std::vector<Section> describeBtf(const formats::Btf& btf, const BtfSheet& sheet);

// The pictures at one exposure that brings their mean to a middle value; dark grey where there is none.
Preview previewBtf(const formats::Btf& btf, const BtfSheet& sheet, const PreviewOptions& options);

}  // namespace bakelight::inspect
