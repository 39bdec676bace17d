#include "formats/btf_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "formats/btf_color.h"
#include "formats/btf_names.h"
#include "formats/color_picture.h"
#include "formats/error.h"
#include "formats/image.h"
#include "formats/picture_files.h"

namespace bakelight::formats {
namespace {

constexpr float kRgbFromXyz[3][3] = {{3.2404542F, -1.5371385F, -0.4985314F},
                                     {-0.9692660F, 1.8760108F, 0.0415560F},
                                     {0.0556434F, -0.2040259F, 1.0572252F}};

bool isPicture(const std::string& name) {
  static const std::set<std::string> kEndings = {".jpg", ".jpeg", ".png", ".exr",
                                                 ".hdr", ".bmp",  ".tif", ".tiff"};
  return kEndings.contains(lowerEnding(name));
}

void toRgbFromXyz(Image& image) {
  for (std::size_t at = 0; at + 3 <= image.values.size(); at += 3) {
    const float x = image.values[at], y = image.values[at + 1], z = image.values[at + 2];
    for (std::size_t c = 0; c < 3; ++c)
      image.values[at + c] = kRgbFromXyz[c][0] * x + kRgbFromXyz[c][1] * y + kRgbFromXyz[c][2] * z;
  }
}

// Three of its channels, weighted sums of all of them, or nothing if they are no colour that is meant here.
std::optional<Image> colorOf(const Image& image) {
  Image color(image.width, image.height, {"R", "G", "B"});
  const std::size_t channels = image.channelCount(), texels = color.values.size() / 3;
  const std::array<int, 3> xyz = {image.channelIndex("X"), image.channelIndex("Y"), image.channelIndex("Z")};
  if (std::ranges::min(xyz) >= 0 && image.channelIndex("R") < 0) {
    for (std::size_t t = 0; t < texels; ++t)
      for (std::size_t c = 0; c < 3; ++c)
        color.values[3 * t + c] = image.values[t * channels + static_cast<std::size_t>(xyz[c])];
    toRgbFromXyz(color);
    return color;
  }
  std::vector<double> wavelengths;
  for (const std::string& name : image.channel_names) wavelengths.push_back(wavelengthOf(name));
  if (std::ranges::find(wavelengths, 0.0) != wavelengths.end()) return std::nullopt;
  const std::vector<std::array<float, 3>> weights = rgbOfWavelengths(wavelengths);
  for (std::size_t t = 0; t < texels; ++t)
    for (std::size_t k = 0; k < channels; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        color.values[3 * t + c] += weights[k][c] * image.values[t * channels + k];
  return color;
}

struct ReadPicture {
  Image image;
  bool decoded = false;  // from sRGB
};

ReadPicture readPicture(const PictureFiles& files, const std::string& name, BtfPictureColors colors) {
  ReadPicture picture;
  bool is_read = false;
  if (lowerEnding(name) == ".exr" && colors == BtfPictureColors::kAutomatic) {
    const auto local = files.local(name);
    if (auto color = colorOf(readImage(local->path()))) picture.image = std::move(*color), is_read = true;
  }
  if (!is_read) {
    ColorPicture read = readColorPicture(files.read(name), files.placeOf(name), PictureUse::kReflectance);
    picture = {std::move(read.image), read.decoded};
  }
  if (colors == BtfPictureColors::kXyz) toRgbFromXyz(picture.image);
  return picture;
}

// What all views share.
struct PictureSet {
  std::unique_ptr<PictureFiles> files;
  BtfPictureColors colors = BtfPictureColors::kAutomatic;
  std::vector<std::map<int, std::string>> pictures = {};  // of each view, by light
};

class PicturesView : public BtfView {
 public:
  PicturesView(std::shared_ptr<const BtfInfo> info, int view, const PictureSet& set)
      : BtfView(std::move(info), view) {
    for (const auto& [light, name] : set.pictures[static_cast<std::size_t>(view)]) {
      Image image = readPicture(*set.files, name, set.colors).image;
      if (image.width != this->info().width || image.height != this->info().height)
        throw badInput(
            {set.files->placeOf(name), "", ""},
            "it has " + std::to_string(image.width) + " × " + std::to_string(image.height) + " pixels",
            std::to_string(this->info().width) + " × " + std::to_string(this->info().height) +
                ", as the others");
      images_.emplace(light, std::move(image));
    }
  }

 private:
  void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const override {
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const float* from = images_.at(lights[i]).values.data() + 3 * texels.first;
      for (std::size_t t = 0; t < texels.count; ++t)
        for (std::size_t c = 0; c < 3; ++c) rgb[(c * lights.size() + i) * texels.count + t] = from[3 * t + c];
    }
  }

  std::map<int, Image> images_;  // by light
};

class PicturesBtf : public Btf {
 public:
  PicturesBtf(BtfInfo info, PictureSet set) : Btf(std::move(info)), set_(std::move(set)) {}
  std::vector<int> lightsOf(int view) const override {
    std::vector<int> lights;
    for (const auto& [light, name] : set_.pictures[static_cast<std::size_t>(view)]) lights.push_back(light);
    return lights;
  }
  std::shared_ptr<const BtfView> view(int view) const override {
    return std::make_shared<PicturesView>(sharedInfo(), view, set_);
  }

 private:
  PictureSet set_;
};

// Azimuths within a turn, none at the zenith: what one direction is called is one.
BtfDirection canonical(const BtfDirection& direction) {
  constexpr double kTurn = 6.283185307179586;
  if (direction.polar_rad == 0) return {0, 0};
  const double azimuth = std::fmod(std::fmod(direction.azimuth_rad, kTurn) + kTurn, kTurn);
  constexpr double kRounding_rad = 1e-9;
  return {direction.polar_rad, azimuth > kTurn - kRounding_rad ? 0 : azimuth};
}

using Key = std::array<double, 2>;
Key keyOf(const BtfDirection& direction) {
  return {direction.polar_rad, direction.azimuth_rad};
}

std::vector<BtfDirection> numbered(std::map<Key, int>& indices) {
  std::vector<BtfDirection> directions;
  for (auto& [key, index] : indices) {
    index = static_cast<int>(directions.size());
    directions.push_back({key[0], key[1]});
  }
  return directions;
}

std::vector<BtfPicture> picturesByName(const PictureFiles& files, const std::string& place,
                                       std::vector<std::string>& notes) {
  std::vector<BtfPicture> pictures;
  std::vector<std::string> others;
  for (const std::string& name : files.names()) {
    if (!isPicture(name)) continue;
    if (auto picture = pictureOfName(name))
      pictures.push_back(std::move(*picture));
    else
      others.push_back(name);
  }
  if (pictures.empty())
    throw badInput({place, others.empty() ? "" : others.front(), ""},
                   others.empty() ? "it holds no picture (.jpg .png .exr .hdr .bmp .tif)"
                                  : "no picture's name states its directions",
                   "names with tl, pl, tv and pv, each with degrees, as in tl000_pl000_tv030_pv060.png",
                   others.empty() ? "" : "give a table of directions");
  if (!others.empty())
    notes.push_back(std::to_string(others.size()) +
                    " pictures whose names state no directions are left out, the first: " + others.front());
  return pictures;
}

std::vector<BtfPicture> picturesByTable(const PictureFiles& files, const std::filesystem::path& table,
                                        const std::string& place, std::vector<std::string>& notes) {
  const std::vector<std::string> names = files.names();
  std::vector<BtfPicture> pictures;
  std::vector<std::string> missing;
  for (BtfPicture& picture : readPictureTable(table)) {
    const bool is_there = std::ranges::binary_search(names, picture.name);
    if (!is_there) missing.push_back(picture.name);
    if (is_there) pictures.push_back(std::move(picture));
  }
  if (pictures.empty())
    throw badInput({place, missing.front(), ""}, "none of the table's pictures is there",
                   "this one, for example");
  if (!missing.empty())
    notes.push_back(std::to_string(missing.size()) +
                    " pictures of the table are missing, the first: " + missing.front());
  return pictures;
}

constexpr std::size_t kMostNamed = 8;

void noteGaps(const BtfInfo& info, const PictureSet& set, std::vector<std::string>& notes) {
  std::size_t missing = 0;
  std::string names;
  for (std::size_t v = 0; v < info.views.size(); ++v)
    for (std::size_t l = 0; l < info.lights.size(); ++l) {
      if (set.pictures[v].contains(static_cast<int>(l))) continue;
      if (missing++ < kMostNamed)
        names += (names.empty() ? "" : ", ") + nameOfDirections(info.views[v], info.lights[l]);
    }
  if (missing > 0)
    notes.push_back(std::to_string(missing) + " of " +
                    std::to_string(info.views.size() * info.lights.size()) +
                    " pairs of directions have no picture: " + names + (missing > kMostNamed ? ", ..." : ""));
}

}  // namespace

bool isPictureSet(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return true;
  std::ifstream file(path, std::ios::binary);
  std::array<char, 4> begin = {};
  file.read(begin.data(), begin.size());
  return file && begin[0] == 'P' && begin[1] == 'K' && (begin[2] == 3 || begin[2] == 5);
}

std::unique_ptr<Btf> openBtfPictures(const std::filesystem::path& path, const BtfPictureOptions& options) {
  BtfInfo info;
  info.file = path.string();
  info.layout = "pictures";
  PictureSet set{.files = openPictureFiles(path), .colors = options.colors};
  std::vector<BtfPicture> pictures = options.table.empty()
                                         ? picturesByName(*set.files, info.file, info.notes)
                                         : picturesByTable(*set.files, options.table, info.file, info.notes);
  std::map<Key, int> views, lights;
  constexpr double kFlat_rad = 1.5707963267948966 + 1e-9;
  for (BtfPicture& picture : pictures) {
    for (const BtfDirection& direction : {picture.view, picture.light})
      if (!(direction.polar_rad >= 0 && direction.polar_rad <= kFlat_rad))
        throw badInput({set.files->placeOf(picture.name), "", ""},
                       "its name states a direction below the horizon", "polar angles from 0 to 90 degrees");
    picture.view = canonical(picture.view), picture.light = canonical(picture.light);
    views[keyOf(picture.view)], lights[keyOf(picture.light)];
  }
  info.views = numbered(views), info.lights = numbered(lights);
  set.pictures.resize(info.views.size());
  std::size_t repeated = 0;
  std::string first_repeated;
  for (const BtfPicture& picture : pictures) {
    auto& of_view = set.pictures[static_cast<std::size_t>(views.at(keyOf(picture.view)))];
    if (of_view.emplace(lights.at(keyOf(picture.light)), picture.name).second) continue;
    if (repeated++ == 0) first_repeated = picture.name;
  }
  if (repeated > 0)
    info.notes.push_back(
        std::to_string(repeated) +
        " pictures show a pair of directions again and are left out, the first: " + first_repeated);
  noteGaps(info, set, info.notes);

  const ReadPicture first = readPicture(*set.files, pictures.front().name, options.colors);
  info.width = first.image.width, info.height = first.image.height;
  info.bytes = set.files->bytes();
  if (first.decoded) info.notes.push_back("its pictures hold integer codes: they are decoded from sRGB");
  return std::make_unique<PicturesBtf>(std::move(info), std::move(set));
}

}  // namespace bakelight::formats
