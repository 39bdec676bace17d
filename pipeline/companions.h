// Files that a file refers to and that belong to its content: what a mesh file names
// (formats/mesh_companions.h), the images and meshes of a light rig (.json).
#pragma once

#include <filesystem>
#include <string>

#include "formats/json.h"
#include "pipeline/disk.h"
#include "pipeline/memo.h"

namespace bakelight::pipeline {

// Content hash of an input file and of all that it refers to. For a file that stands alone it is
// Memo::hashOf. What is referred to and missing, or a file that should be JSON and is not, is left for the
// tool to report. Throws Error(kBadInput) if `path` itself cannot be read.
std::string hashWithCompanions(const std::filesystem::path& path, const Disk& disk, Memo& memo);

// Content hash of a text that stands in place of a file, and of the files that it names under "file" with what these
// refer to.
std::string hashWithNamedFiles(const formats::Json& value, const Disk& disk, Memo& memo);
// The same text for a reader that stands elsewhere: with absolute paths of these files.
formats::Json withAbsolutePaths(formats::Json value);

}  // namespace bakelight::pipeline
