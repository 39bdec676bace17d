// Sum grammars in safetensors files (docs/FORMATS.md), a tensor a stream.
#pragma once

#include <filesystem>
#include <string>

#include "formats/sum_grammar_code.h"
#include "formats/tensors.h"

namespace bakelight::formats {

// What encodeSumGrammar writes, without what the caller adds. The same grammar gives the same bytes.
TensorFile encodeSumGrammar(const SumGrammar& grammar);

// Shares the tensors' bytes, which are those that were written: a digest is checked. Throws Error(kBadInput) naming file and tensor or key.
CodedSums codedSumsOf(const TensorFile& file, const std::string& name);

// Equal to what was encoded. All tensors are checked: whatever the bytes are, the result is one that products can be taken of. Throws
// Error(kBadInput) naming file and tensor.
SumGrammar decodeSumGrammar(const TensorFile& file, const std::string& name);

// Bytes of the tensors of the grammar itself.
std::uint64_t encodedBytes(const TensorFile& file);

}  // namespace bakelight::formats
