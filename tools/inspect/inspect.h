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

// Throws Error(kBadInput) if the file is none of file_kind.h's, is damaged, or has nothing to draw although
// `preview` is given (a record).
Inspection inspectFile(const std::filesystem::path& path, const std::optional<PreviewOptions>& preview);

}  // namespace bakelight::inspect
