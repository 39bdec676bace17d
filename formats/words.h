// Words that people write, in files and on command lines: those that stand for the values of an enumeration,
// and what messages say of a word that is none of them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace bakelight::formats {

// One row of the table of an enumeration's words. The table is all that command lines, files, --describe and
// messages know of it:
//   inline constexpr Word<Background> kBackgrounds[] = {{"black", Background::kBlack}, …};
template <class Value>
struct Word {
  const char* text;
  Value value;
};

template <class Value, std::size_t N>
std::vector<std::string> textsOf(const Word<Value> (&words)[N]) {
  std::vector<std::string> texts;
  for (const Word<Value>& word : words) texts.emplace_back(word.text);
  return texts;
}

// The word for `value`, which must have one.
template <class Value, std::size_t N>
constexpr const char* wordFor(const Word<Value> (&words)[N], Value value) {
  std::size_t i = 0;
  while (i + 1 < N && !(words[i].value == value)) ++i;
  return words[i].text;
}

// Null if no value has this word.
template <class Value, std::size_t N>
constexpr const Value* valueFor(const Word<Value> (&words)[N], std::string_view text) {
  for (const Word<Value>& word : words)
    if (text == word.text) return &word.value;
  return nullptr;
}

std::size_t editDistance(std::string_view a, std::string_view b);

// The candidate with the smallest edit distance to `name`, or "" if none is near enough to be a likely
// misspelling.
template <class Strings>
std::string nearestName(std::string_view name, const Strings& candidates) {
  std::string best;
  std::size_t best_distance = name.size() / 3 + 2;
  for (const auto& candidate : candidates) {
    const std::size_t distance = editDistance(name, candidate);
    if (distance < best_distance) best = candidate, best_distance = distance;
  }
  return best;
}

// The remedy for a name that is none of `candidates`: `write "NEAREST"`, or "" if nothing is near.
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

std::string join(const std::vector<std::string>& words, const std::string& separator);

}  // namespace bakelight::formats
