#include "formats/btf_names.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json_reader.h"

namespace bakelight::formats {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}
bool isLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

// The number right behind `key`, in degrees; a point counts if a digit follows it.
std::optional<double> numberBehind(std::string_view text, std::string_view key) {
  for (std::size_t at = text.find(key); at != std::string_view::npos; at = text.find(key, at + 1)) {
    if (at > 0 && isLetter(text[at - 1])) continue;
    const std::size_t begin = at + key.size();
    std::size_t end = begin;
    if (end < text.size() && text[end] == '-') ++end;
    const std::size_t first_digit = end;
    while (end < text.size() && isDigit(text[end])) ++end;
    if (end == first_digit) continue;
    if (end + 1 < text.size() && text[end] == '.' && isDigit(text[end + 1]))
      for (++end; end < text.size() && isDigit(text[end]);) ++end;
    double value = 0;
    if (std::from_chars(text.data() + begin, text.data() + end, value).ec == std::errc()) return value;
  }
  return std::nullopt;
}

constexpr double kFlat_deg = 90, kTurn_deg = 360;

BtfDirection directionOf(double polar_deg, double azimuth_deg) {
  return {polar_deg * kDegree, azimuth_deg * kDegree};
}

BtfDirection directionAt(const JsonReader& entry, const char* key) {
  const JsonReader angles = entry.at(key, "a polar angle and an azimuth, in degrees");
  if (angles.size() != 2)
    throw angles.error("it has " + std::to_string(angles.size()) + " numbers",
                       "2: a polar angle and an azimuth, in degrees");
  return directionOf(angles.at(std::size_t{0}).number(NumberRange{0, kFlat_deg}),
                     angles.at(std::size_t{1}).number(NumberRange{-kTurn_deg, kTurn_deg}));
}

std::vector<BtfPicture> readJsonTable(const std::filesystem::path& path) {
  const Json json = readJson(path);
  const JsonReader reader(json, path.string());
  std::vector<BtfPicture> pictures;
  for (const JsonReader& entry : reader.at("pictures").items()) {
    pictures.push_back({entry.text("file"), directionAt(entry, "view"), directionAt(entry, "light")});
    entry.refuseOthers();
  }
  reader.refuseOthers();
  return pictures;
}

constexpr std::string_view kColumns =
    "file,view_polar_deg,view_azimuth_deg,light_polar_deg,light_azimuth_deg";

std::vector<std::string_view> splitAt(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<BtfPicture> readCsvTable(const std::filesystem::path& path) {
  const std::string text = readTextFile(path);
  std::vector<BtfPicture> pictures;
  std::size_t number = 0;
  for (std::string_view line : splitAt(text, '\n')) {
    ++number;
    line = trimmed(line);
    const auto wrong = [&](const std::string& what, const std::string& expected) {
      return badInput({path.string(), "line " + std::to_string(number), ""}, what, expected);
    };
    if (number == 1) {
      if (line != kColumns)
        throw wrong("the columns are " + std::string(line.substr(0, 100)), std::string(kColumns));
      continue;
    }
    if (line.empty() || line.front() == '#') continue;
    const std::vector<std::string_view> cells = splitAt(line, ',');
    if (cells.size() != 5)
      throw wrong("it has " + std::to_string(cells.size()) + " cells",
                  "5: a file and four angles in degrees");
    std::array<double, 4> angles = {};
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const std::string_view cell = trimmed(cells[i + 1]);
      const auto [end, failed] = std::from_chars(cell.data(), cell.data() + cell.size(), angles[i]);
      const bool is_polar = i % 2 == 0;
      if (failed != std::errc() || end != cell.data() + cell.size() || !(std::abs(angles[i]) <= kTurn_deg) ||
          (is_polar && !(angles[i] >= 0 && angles[i] <= kFlat_deg)))
        throw wrong("\"" + std::string(cell) + "\" is no " + (is_polar ? "polar angle" : "azimuth"),
                    is_polar ? "0 to 90 degrees" : "-360 to 360 degrees");
    }
    pictures.push_back({std::string(trimmed(cells[0])), directionOf(angles[0], angles[1]),
                        directionOf(angles[2], angles[3])});
  }
  return pictures;
}

}  // namespace

std::optional<BtfPicture> pictureOfName(const std::string& name) {
  const std::string base = name.substr(name.find_last_of('/') + 1);
  const auto view_polar = numberBehind(base, "tv"), view_azimuth = numberBehind(base, "pv");
  const auto light_polar = numberBehind(base, "tl"), light_azimuth = numberBehind(base, "pl");
  if (!view_polar || !view_azimuth || !light_polar || !light_azimuth) return std::nullopt;
  return BtfPicture{name, directionOf(*view_polar, *view_azimuth), directionOf(*light_polar, *light_azimuth)};
}

std::vector<BtfPicture> readPictureTable(const std::filesystem::path& path) {
  std::vector<BtfPicture> pictures = lowerEnding(path) == ".csv" ? readCsvTable(path) : readJsonTable(path);
  if (pictures.empty()) throw badInput({path.string(), "", ""}, "it names no picture", "one or more");
  return pictures;
}

std::string nameOfDirections(const BtfDirection& view, const BtfDirection& light) {
  return fmt::format("tv{:03.4g}_pv{:03.4g}_tl{:03.4g}_pl{:03.4g}", view.polar_rad / kDegree,
                     view.azimuth_rad / kDegree, light.polar_rad / kDegree, light.azimuth_rad / kDegree);
}

}  // namespace bakelight::formats
