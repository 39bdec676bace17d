#include "formats/mesh_mtl.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/error.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace {

class MtlReader {
 public:
  MtlReader(std::string_view text, std::string file)
      : lines_(withoutByteOrderMark(text)), file_(std::move(file)) {}

  MtlFile read() {
    for (std::string_view line; lines_.next(line);) {
      std::string_view rest = line;
      const std::string_view keyword = takeWord(rest);
      if (equalIgnoringCase(keyword, "newmtl")) {
        finishMaterial();
        material_ = {.name = std::string(withoutComment(rest)), .color = {}, .texture = {}};
        inside_ = true;
      } else if (!inside_) {
        continue;  // comments, or a line of another library's
      } else if (equalIgnoringCase(keyword, "Kd")) {
        readColor(withoutComment(rest));
      } else if (equalIgnoringCase(keyword, "map_Kd")) {
        readTexture(withoutComment(rest));
      }
    }
    finishMaterial();
    return std::move(result_);
  }

 private:
  Error error(const std::string& what, const std::string& expected) const {
    return badInput({file_, "line " + std::to_string(lines_.lineNumber()), ""}, what, expected,
                    "correct the line, or export the materials again");
  }

  void note(const std::string& text) {
    result_.notes.push_back(file_ + ", line " + std::to_string(lines_.lineNumber()) + ": " + text);
  }

  // A name may contain '#'; a comment stands apart.
  static std::string_view withoutComment(std::string_view text) {
    for (std::size_t hash = text.find('#'); hash != std::string_view::npos; hash = text.find('#', hash + 1))
      if (hash > 0 && isBlank(text[hash - 1]) && !trimmed(text.substr(0, hash)).empty())
        return trimmed(text.substr(0, hash));
    return trimmed(text);
  }

  void finishMaterial() {
    if (!inside_) return;
    const bool again = std::any_of(result_.materials.begin(), result_.materials.end(),
                                   [&](const MtlMaterial& other) { return other.name == material_.name; });
    if (again) {
      note("the material '" + material_.name + "' that ends here stands twice; the first one counts");
      return;
    }
    if (material_.texture && material_.color == Float3{0, 0, 0}) {
      result_.notes.push_back(file_ + ", line " + std::to_string(material_.texture->line) + ": Kd of '" +
                              material_.name + "' is black, so its map_Kd counts alone");
      material_.color.reset();
    }
    result_.materials.push_back(std::move(material_));
  }

  void readColor(std::string_view rest) {
    std::string_view words = rest;
    const std::string_view first = takeWord(words);
    if (equalIgnoringCase(first, "xyz") || equalIgnoringCase(first, "spectral")) {
      note("Kd " + std::string(first) + " is not read, only Kd r g b: '" + material_.name +
           "' has no colour");
      return;
    }
    Float3 color = {};
    int count = 0;
    for (auto word = takeWord(rest); !word.empty() && count < 3; word = takeWord(rest), ++count) {
      const auto value = parseFloat(word);
      if (!value || !std::isfinite(*value))
        throw error("'" + std::string(word) + "' is no colour", "Kd r g b");
      color[static_cast<std::size_t>(count)] = *value;
    }
    if (count != 1 && count != 3)
      throw error("Kd has " + std::to_string(count) + " numbers", "Kd r g b, or Kd r for a grey");
    if (count == 1) color[1] = color[2] = color[0];
    material_.color = color;
  }

  // Up to three numbers, of which the first two concern a picture.
  static int takeNumbers(std::string_view& rest, Float2& values) {
    int count = 0;
    for (; count < 3; ++count) {
      std::string_view ahead = rest;
      const std::string_view word = takeWord(ahead);
      const auto value = parseFloat(word);
      // The last word is the file, whatever it looks like.
      if (!value || !std::isfinite(*value) || trimmed(ahead).empty()) break;
      if (count < 2) values[static_cast<std::size_t>(count)] = *value;
      rest = ahead;
    }
    return count;
  }

  // How many words an option of no concern for the albedo takes; −1 for an unknown option.
  static int wordsOf(std::string_view option) {
    constexpr std::pair<std::string_view, int> kOptions[] = {
        {"-blendu", 1}, {"-blendv", 1},  {"-cc", 1},   {"-boost", 1},     {"-bm", 1},
        {"-texres", 1}, {"-imfchan", 1}, {"-type", 1}, {"-colorspace", 1}};
    for (const auto& [name, words] : kOptions)
      if (equalIgnoringCase(option, name)) return words;
    return -1;
  }

  void readTexture(std::string_view rest) {
    MtlTexture texture{.name = "", .line = lines_.lineNumber()};
    while (true) {
      std::string_view ahead = rest;
      const std::string_view word = takeWord(ahead);
      if (!word.starts_with('-') || word.size() < 2 || trimmed(ahead).empty()) break;
      if (!takeOption(word, ahead, texture)) break;
      rest = ahead;
    }
    texture.name = trimmed(rest);
    if (texture.name.empty()) throw error("map_Kd names no file", "map_Kd picture.png");
    material_.texture = texture;
  }

  // False if it is the beginning of a file's name.
  bool takeOption(std::string_view option, std::string_view& rest, MtlTexture& texture) {
    if (equalIgnoringCase(option, "-s") || equalIgnoringCase(option, "-o")) {
      takeNumbers(rest, equalIgnoringCase(option, "-s") ? texture.scale : texture.offset);
    } else if (equalIgnoringCase(option, "-t")) {
      Float2 turbulence = {0, 0};
      takeNumbers(rest, turbulence);
      if (turbulence != Float2{0, 0}) note("the turbulence (-t) of map_Kd is left out");
    } else if (equalIgnoringCase(option, "-mm")) {
      const auto base = parseFloat(takeWord(rest)), gain = parseFloat(takeWord(rest));
      if (base != 0.0F || gain != 1.0F) note("base and gain (-mm) of map_Kd are left out");
    } else if (equalIgnoringCase(option, "-clamp")) {
      texture.clamp = equalIgnoringCase(takeWord(rest), "on");
    } else {
      const int words = wordsOf(option);
      if (words < 0) return false;
      for (int i = 0; i < words; ++i) takeWord(rest);
    }
    return true;
  }

  LineScanner lines_;
  std::string file_;
  MtlFile result_;
  MtlMaterial material_;
  bool inside_ = false;
};

}  // namespace

MtlFile readMtl(std::string_view text, const std::string& file) {
  return MtlReader(text, file).read();
}

}  // namespace bakelight::formats
