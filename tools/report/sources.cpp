#include "tools/report/sources.h"

#include "formats/light_rig_file.h"
#include "formats/pack.h"

namespace bakelight::report {

Sources fileSources() {
  return {formats::readPack,
          [](const std::filesystem::path& path) { return std::filesystem::file_size(path); },
          [](const std::filesystem::path& path) { return formats::readImage(path); },
          formats::readImageMetadata, formats::readLights};
}

}  // namespace bakelight::report
