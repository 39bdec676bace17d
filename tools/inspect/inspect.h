// Looks into any file that the project reads or writes.
#pragma once

#include <filesystem>
#include <optional>

#include "tools/inspect/preview.h"
#include "tools/inspect/summary.h"

namespace bakelight::inspect {

struct Inspection {
  Summary summary;
  std::optional<Preview> preview;  // if asked for
};

// What a picture of a mesh may show through its texture coordinates.
struct PatchFiles {
  std::filesystem::path id_map, exemplar;  // either may be empty; the second needs the first
};

// Throws Error(kBadInput) if the file is none of file_kind.h's, is damaged, or has nothing to draw although
// `preview` is given (a record).
Inspection inspectFile(const std::filesystem::path& path, const std::optional<PreviewOptions>& preview,
                       const PatchFiles& patch = {});

}  // namespace bakelight::inspect
