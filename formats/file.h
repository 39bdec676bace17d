// Whole files in and out of memory. Every writer of the project goes through writeFileAtomically, so that a
// full disk, a crash or an interruption never leaves a half-written file under its final name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace bakelight::formats {

using Bytes = std::vector<std::byte>;

// Throws Error(kBadInput) if the file is missing, is a folder, or cannot be read.
Bytes readFile(const std::filesystem::path& path);
std::string readTextFile(const std::filesystem::path& path);

// What the name of `path` ends with, with the dot and in lowercase (ASCII): ".obj" of "Bunny.OBJ". Files are
// told apart by it.
std::string lowerEnding(const std::filesystem::path& path);

// Writes to a temporary name in the same folder, syncs, then renames over `path`; makes missing parent
// folders. Throws Error(kCannotWrite) and removes the temporary file if anything fails; `path` keeps its old
// content then.
void writeFileAtomically(const std::filesystem::path& path, std::span<const std::byte> bytes);
void writeFileAtomically(const std::filesystem::path& path, std::string_view text);

// For a signal handler (async-signal-safe): removes the temporary file that a write of this process is
// filling right now.
void removeUnfinishedFile() noexcept;

}  // namespace bakelight::formats
