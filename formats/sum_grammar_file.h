// Sum grammars in safetensors files (docs/FORMATS.md): entries by where they lie and how often they are used, entropy-coded.
#pragma once

#include <filesystem>
#include <string>

#include "formats/sum_grammar.h"
#include "formats/tensors.h"

namespace bakelight::formats {

// What encodeSumGrammar writes, without what the caller adds. The same grammar gives the same bytes.
TensorFile encodeSumGrammar(const SumGrammar& grammar);

// Equal to what was encoded. All tensors are checked: whatever the bytes are, the result is one that products can be taken of. Throws
// Error(kBadInput) naming file and tensor.
SumGrammar decodeSumGrammar(const TensorFile& file, const std::string& name);

// Bytes of the tensors of the grammar itself.
std::uint64_t encodedBytes(const TensorFile& file);

}  // namespace bakelight::formats
