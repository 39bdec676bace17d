// BTFs as folders or zips of pictures, one for each pair of directions (docs/BTF.md): UBO2003, ATRIUM, SPECTRAL, UTIA by
// the names of the files; CUReT and others by a table.
#pragma once

#include <filesystem>
#include <memory>

#include "formats/btf.h"

namespace bakelight::formats {

enum class BtfPictureColors {
  kAutomatic,  // by the names of the channels: red, green and blue; X, Y and Z; wavelengths; grey
  kXyz         // whatever their names, CIE XYZ (D65)
};

struct BtfPictureOptions {
  std::filesystem::path table = {};  // of directions; empty: they are in the names
  BtfPictureColors colors = BtfPictureColors::kAutomatic;
};

// Whether the path is a folder, or a file that begins as a zip does.
bool isPictureSet(const std::filesystem::path& path);

// Opens them; pictures are read when a view is asked for, and all of a view's are held then. Integer codes are decoded
// from sRGB. Pairs of directions without a picture are gaps (Btf::lightsOf), told with the other notes, as are files
// that state no directions. Cosines of light are taken to be inside, as in photographs. Throws
// Error(kBadInput) naming folder, zip or picture: none that states directions, an angle beyond the horizon, different
// sizes, what cannot be decoded, a damaged or encrypted zip.
std::unique_ptr<Btf> openBtfPictures(const std::filesystem::path& path,
                                     const BtfPictureOptions& options = {});

}  // namespace bakelight::formats
