// OpenEXR files as the OpenEXR library has them. Private to formats/.
#pragma once

#include <OpenEXR/ImfForward.h>

#include <cstddef>
#include <filesystem>
#include <memory>

namespace bakelight::formats {

// Threads that (de)compress so many values: 0 for few, else all cores.
int exrThreadsFor(std::size_t values);

// A flat part that fills its frame, without subsampling or orientation.
bool isPlainExr(const Imf::Header& header);

// A file of one such part, for reading so many values. Throws Error(kBadInput) naming the file for any other.
std::unique_ptr<Imf::MultiPartInputFile> openPlainExr(const std::filesystem::path& path, std::size_t values);

}  // namespace bakelight::formats
