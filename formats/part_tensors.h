// A part of a pack on its own, as a safetensors file: what a stage bakes and pack puts in as it is. Arrays are named by the part's fields,
// "near.values"; numbers are metadata.
#pragma once

#include <string>

#include "formats/pack_part.h"
#include "formats/tensors.h"

namespace bakelight::formats {

TensorFile tensorsOf(PackPart& part);
// Fills `part` in. Throws Error(kBadInput) naming file and tensor or key: missing, of another type or shape, out of range, or what the
// part's own rules refuse.
void readPart(PackPart& part, const TensorFile& tensors, const std::string& file);

}  // namespace bakelight::formats
