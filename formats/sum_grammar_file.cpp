#include "formats/sum_grammar_file.h"

#include <charconv>
#include <limits>

#include "formats/error.h"
#include "formats/hash.h"
#include "formats/pixel_transfer.h"

namespace bakelight::formats {
namespace {

std::uint64_t numberOf(const TensorFile& file, const std::string& key, std::uint64_t least,
                       std::uint64_t most, const std::string& name) {
  const std::string& text = file.requireMetadata(key, name);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < least || value > most)
    throw badInput({name, "metadata " + key, ""}, "\"" + text + "\" is not a number that it may be",
                   std::to_string(least) + " to " + std::to_string(most), "make the file again");
  return value;
}

// Of all streams one after the other: Draco's decoder is for whole bytes, so broken ones are found before it sees them.
std::string digestOf(const TensorFile& file) {
  std::string digests;
  for (const char* stream : kSumStreamNames)
    if (const auto found = file.tensors.find(stream); found != file.tensors.end())
      digests += checksumHex(std::span(found->second.data.data(), found->second.data.size()));
  return contentHash(digests);
}

}  // namespace

TensorFile encodeSumGrammar(const SumGrammar& grammar) {
  TensorFile file;
  const CodedSums coded = encodeSums(grammar);
  for (int stream = 0; stream < kSumStreams; ++stream)
    file.tensors[kSumStreamNames[stream]] = {
        ElementType::kUint8, {coded.streams[stream].size()}, coded.streams[stream]};
  file.metadata = {{"technique", "sum_grammar"},
                   {"cube_side", std::to_string(grammar.cube_side)},
                   {"local_side", std::to_string(grammar.local_side)},
                   {"subsamples", std::to_string(grammar.subsamples)},
                   {"rows", std::to_string(grammar.row_count)},
                   {"digest", digestOf(file)}};
  return file;
}

CodedSums codedSumsOf(const TensorFile& file, const std::string& name) {
  CodedSums coded;
  coded.cube_side = static_cast<int>(numberOf(file, "cube_side", 1, kMostCubeSide, name));
  coded.local_side = static_cast<int>(numberOf(file, "local_side", 1, kMostLocalSide, name));
  coded.subsamples = static_cast<int>(numberOf(file, "subsamples", 1, kMostSubsamples, name));
  coded.row_count = numberOf(file, "rows", 0, std::numeric_limits<std::uint32_t>::max() - 1, name);
  if (file.requireMetadata("digest", name) != digestOf(file))
    throw badInput({name, "metadata digest", ""}, "the tensors are not those that were written",
                   "an undamaged file", "make the file again");
  for (int stream = 0; stream < kSumStreams; ++stream)
    coded.streams[stream] = file.require(kSumStreamNames[stream], ElementType::kUint8, 1, name).data;
  return coded;
}

SumGrammar decodeSumGrammar(const TensorFile& file, const std::string& name) {
  return decodeSums(codedSumsOf(file, name), name);
}

std::uint64_t encodedBytes(const TensorFile& file) {
  std::uint64_t bytes = 0;
  for (const char* stream : kSumStreamNames) bytes += file.tensors.at(stream).data.size();
  return bytes;
}

}  // namespace bakelight::formats
