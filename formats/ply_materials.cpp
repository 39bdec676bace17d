#include "formats/ply_materials.h"

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace bakelight::formats {
namespace {

constexpr std::string_view kWord = " material ";

std::string escaped(const std::string& name) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte > ' ' && byte < 0x7F && byte != '%')
      text += c;
    else
      text += {'%', kDigits[byte / 16], kDigits[byte % 16]};
  }
  return text;
}

std::optional<std::string> unescaped(std::string_view text) {
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      name += text[i];
      continue;
    }
    std::uint8_t byte = 0;
    const char* first = text.data() + i + 1;
    if (text.size() - i < 3 || std::from_chars(first, first + 2, byte, 16).ptr != first + 2)
      return std::nullopt;
    name += static_cast<char>(byte);
    i += 2;
  }
  return name;
}

}  // namespace

std::string plyMaterialComment(std::size_t index, const std::string& name) {
  return std::string(kWord) + std::to_string(index) + " " + escaped(name);
}

std::vector<std::string> plyMaterialNames(const std::vector<std::string>& comments) {
  std::vector<std::string> names;
  for (const std::string& comment : comments) {
    const std::string begin = std::string(kWord) + std::to_string(names.size());
    if (!comment.starts_with(begin)) continue;
    std::string_view rest = std::string_view(comment).substr(begin.size());
    if (!rest.empty() && rest.front() != ' ') continue;  // 10 where 1 is due
    if (!rest.empty()) rest.remove_prefix(1);
    if (const auto name = unescaped(rest)) names.push_back(*name);
  }
  return names;
}

}  // namespace bakelight::formats
