// Directions that names of pictures state, and tables of them. Private to formats/.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/btf.h"

namespace bakelight::formats {

struct BtfPicture {
  std::string name;  // of the file, in its folder or zip
  BtfDirection view, light;
};

// The last part of the name has four keys, in any order and with anything between them: "tl", "pl", "tv", "pv", polar
// angle and azimuth of light and view, each with a number of degrees right behind it ("tl045", "pv12.5"). Nothing
// without all four.
std::optional<BtfPicture> pictureOfName(const std::string& name);

// JSON: { "pictures": [{ "file": …, "view": [polar, azimuth], "light": [polar, azimuth] }, …] }, or CSV with the header
// file,view_polar_deg,view_azimuth_deg,light_polar_deg,light_azimuth_deg; degrees. Throws Error(kBadInput).
std::vector<BtfPicture> readPictureTable(const std::filesystem::path& path);

// "tv030_pv000_tl045_pl090"
std::string nameOfDirections(const BtfDirection& view, const BtfDirection& light);

}  // namespace bakelight::formats
