// What follows the header of a `.btf` file, by layout. Private to formats/.
#pragma once

#include <memory>

#include "formats/btf.h"
#include "formats/btf_header.h"
#include "formats/mapped_file.h"

namespace bakelight::formats {

struct OpenedBtf {
  std::shared_ptr<const MappedFile> file;
  BtfSignature signature;
  BtfCursor cursor;  // behind the signature
};

// Decorrelated full-matrix factorisation: a matrix of directions × texels for each channel.
std::unique_ptr<Btf> openDecorrelatedBtf(OpenedBtf opened);
// Full-matrix factorisation: one matrix, channels beside directions or texels.
std::unique_ptr<Btf> openFullMatrixBtf(OpenedBtf opened);
// A factorisation of its own for each view.
std::unique_ptr<Btf> openPerViewBtf(OpenedBtf opened);
// All values, texel by texel.
std::unique_ptr<Btf> openRawBtf(OpenedBtf opened);

}  // namespace bakelight::formats
