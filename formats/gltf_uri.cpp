#include "formats/gltf_uri.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "formats/json.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

constexpr std::int8_t kOther = -1, kBlank = -2, kPadding = -3;

constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

constexpr std::array<std::int8_t, 256> base64Table() {
  std::array<std::int8_t, 256> table{};
  table.fill(kOther);
  std::int8_t value = 0;
  for (const char c : kDigits) table[static_cast<unsigned char>(c)] = value++;
  table['-'] = 62, table['_'] = 63;
  for (const char c : {' ', '\t', '\r', '\n'}) table[static_cast<unsigned char>(c)] = kBlank;
  table['='] = kPadding;
  return table;
}

// Returns what is wrong, or "".
std::string decodeBase64(std::string_view text, Bytes& bytes) {
  static constexpr auto kTable = base64Table();
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  std::size_t digits = 0, padding = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::int8_t value = kTable[static_cast<unsigned char>(text[i])];
    if (value == kBlank) continue;
    if (value == kOther || (value != kPadding && padding > 0)) {
      return "character " + std::to_string(i) + " of its base64 data is none of base64";
    }
    if (value == kPadding) {
      ++padding;
      continue;
    }
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    if (++digits % 4 != 0) continue;
    for (const int shift : {16, 8, 0}) bytes.push_back(static_cast<std::byte>(bits >> shift));
  }
  const std::size_t rest = digits % 4;
  if (rest == 1 || padding > 2 || (padding > 0 && (rest + padding) % 4 != 0)) {
    return "its base64 data ends inside a group of four";
  }
  if (rest >= 2) bytes.push_back(static_cast<std::byte>(bits << (6 * (4 - rest)) >> 16));
  if (rest == 3) bytes.push_back(static_cast<std::byte>(bits << 6 >> 8));
  return "";
}

// The scheme of an absolute URI in lowercase, or "".
std::string schemeOf(std::string_view uri) {
  std::string scheme;
  for (const char c : uri) {
    if (c == ':') return scheme;
    const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool is_other = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    if (!is_letter && !(is_other && !scheme.empty())) return "";
    scheme += static_cast<char>(is_letter ? c | 0x20 : c);
  }
  return "";
}

void add(std::vector<fs::path>& paths, const std::string& text) {
  if (text.empty() || text.find('\0') != std::string::npos) return;
  if (std::find(paths.begin(), paths.end(), fs::path(text)) == paths.end()) paths.emplace_back(text);
}

void collectUris(const Json& document, const char* section, std::set<fs::path>& paths) {
  if (!document.is_object() || !document.contains(section)) return;
  for (const Json& element : document[section]) {
    if (!element.is_object() || !element.contains("uri") || !element["uri"].is_string()) continue;
    const auto& uri = element["uri"].get_ref<const std::string&>();
    if (isDataUri(uri)) continue;
    for (const fs::path& path : pathsOfUri(uri)) paths.insert(path);
  }
}

std::uint32_t uint32At(std::span<const std::byte> bytes, std::size_t offset) {
  static_assert(std::endian::native == std::endian::little);
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

std::string percentDecoded(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const int high = text[i] == '%' && i + 2 < text.size() ? hexDigit(text[i + 1]) : -1;
    const int low = high >= 0 ? hexDigit(text[i + 2]) : -1;
    if (low < 0) {
      result += text[i];
      continue;
    }
    result += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return result;
}

bool isDataUri(std::string_view uri) {
  return uri.size() >= 5 && schemeOf(uri.substr(0, 5)) == "data";
}

DataUri readDataUri(std::string_view uri) {
  DataUri result;
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return {.fault = "the data URI has no comma before its data"};
  constexpr std::size_t kScheme = 5;  // "data:"
  std::string_view head = uri.substr(kScheme, comma - kScheme);
  std::string_view data = uri.substr(comma + 1);
  result.media_type = head.substr(0, head.find(';'));
  std::string decoded;
  if (data.find('%') != std::string_view::npos) data = decoded = percentDecoded(data);
  if (head.ends_with(";base64")) {
    result.fault = decodeBase64(data, result.bytes);
  } else {
    const auto bytes = std::as_bytes(std::span(data));
    result.bytes.assign(bytes.begin(), bytes.end());
  }
  return result;
}

std::string dataUri(std::string_view media_type, std::span<const std::byte> bytes) {
  std::string uri = "data:";
  uri.append(media_type).append(";base64,");
  uri.reserve(uri.size() + 4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) uri += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return uri;
}

std::vector<fs::path> pathsOfUri(std::string_view uri) {
  std::vector<fs::path> paths;
  const std::string scheme = schemeOf(uri);
  if (scheme == "file") {
    uri.remove_prefix(5);
    if (uri.starts_with("//")) uri.remove_prefix(std::min(uri.find('/', 2), uri.size()));  // and the host
    add(paths, percentDecoded(uri));
    return paths;
  }
  if (scheme.size() > 1) return paths;  // one letter is a drive of Windows
  const std::string decoded = percentDecoded(uri);
  add(paths, decoded);
  add(paths, std::string(uri));
  std::string slashes = decoded;
  std::replace(slashes.begin(), slashes.end(), '\\', '/');
  add(paths, slashes);
  return paths;
}

std::string_view gltfJson(std::span<const std::byte> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::size_t kHeaders = 20;
  if (!text.starts_with("glTF")) return text;
  if (bytes.size() < kHeaders) return "";
  return text.substr(kHeaders, uint32At(bytes, 12));
}

std::vector<fs::path> gltfCompanions(std::span<const std::byte> bytes) {
  const Json document = Json::parse(gltfJson(bytes), nullptr, false, /*ignore_comments=*/true);
  std::set<fs::path> paths;
  collectUris(document, "buffers", paths);
  collectUris(document, "images", paths);
  return {paths.begin(), paths.end()};
}

}  // namespace bakelight::formats
