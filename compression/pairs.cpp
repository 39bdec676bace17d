#include <algorithm>
#include <bit>
#include <unordered_map>

#include "compression/symbol_lists.h"

namespace bakelight::compression {
namespace {

// Of a long list, pairs farther apart are not looked at: their number would grow with its square.
constexpr std::size_t kReach = 24;

struct PairSlot {
  Symbol first = 0, second = 0;
  std::uint32_t count = 0;  // lists with the pair
  std::uint32_t taken = 0;  // lists that would have the sum in its place
  Symbol sum = ~Symbol{0};
};

std::uint64_t mixed(Symbol first, Symbol second) {
  std::uint64_t x = (std::uint64_t{first} << 32 | second) * 0x9e3779b97f4a7c15U;
  x = (x ^ x >> 29) * 0xbf58476d1ce4e5b9U;
  return x ^ x >> 32;
}

class Round {
 public:
  Round(SymbolLists& lists, std::uint32_t threshold, std::size_t most_symbols)
      : lists_(lists),
        threshold_(threshold),
        most_symbols_(most_symbols),
        frequencies_(lists.hashes.size(), 0) {}

  void run() {
    for (const Symbol symbol : lists_.symbols) ++frequencies_[symbol];
    countPairs();
    for (std::uint32_t i = 0; i < lists_.listCount(); ++i) choose(i);
    replace();
  }

 private:
  struct Chosen {
    std::uint32_t list, slot;
  };
  struct Candidate {
    double order;
    std::uint32_t slot;
    std::uint64_t tie;
    std::uint32_t first, second;  // among the list's frequent symbols
  };

  template <class Function>
  static void forPairs(std::size_t length, const Function& function) {
    for (std::size_t i = 0; i < length; ++i)
      for (std::size_t j = i + 1; j < std::min(length, i + 1 + kReach); ++j) function(i, j);
  }

  bool isFrequent(Symbol symbol) const { return frequencies_[symbol] >= threshold_; }

  // A pair is in no more lists than either of its symbols: the others need not be paired.
  std::span<const Symbol> frequentSymbols(std::size_t i) {
    frequent_.clear();
    for (const Symbol symbol : lists_.list(i))
      if (isFrequent(symbol)) frequent_.push_back(symbol);
    return frequent_;
  }

  void countPairs() {
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < lists_.listCount(); ++i) {
      const auto list = lists_.list(i);
      const auto length = static_cast<std::size_t>(
          std::count_if(list.begin(), list.end(), [&](Symbol symbol) { return isFrequent(symbol); }));
      if (length < 2) continue;
      pairs += length <= kReach ? length * (length - 1) / 2 : length * kReach;
    }
    slots_.assign(std::bit_ceil(pairs + pairs / 2 + 2), {});
    slot_of_pair_.reserve(pairs);
    for (std::size_t i = 0; i < lists_.listCount(); ++i) {
      const auto list = frequentSymbols(i);
      forPairs(list.size(), [&](std::size_t a, std::size_t b) {
        slot_of_pair_.push_back(slotOf(list[a], list[b]));
        ++slots_[slot_of_pair_.back()].count;
      });
    }
  }

  std::uint32_t slotOf(Symbol first, Symbol second) const {
    std::size_t at = mixed(first, second) & (slots_.size() - 1);
    for (;; at = (at + 1) & (slots_.size() - 1)) {
      PairSlot& slot = slots_[at];
      if (slot.count == 0) {
        slot.first = first, slot.second = second;
        break;
      }
      if (slot.first == first && slot.second == second) break;
    }
    return static_cast<std::uint32_t>(at);
  }

  // A pair is worth its count, and the more the less its symbols occur without each other, where they would miss what is joined.
  double orderOf(const PairSlot& pair) const {
    const double count = pair.count;
    return count * count / (frequencies_[pair.first] + frequencies_[pair.second]);
  }

  // The list's best pairs that do not overlap. A sum of two parts is itself such a pair's sum.
  void choose(std::uint32_t i) {
    const auto list = frequentSymbols(i);
    std::size_t pair = next_pair_;
    candidates_.clear();
    forPairs(list.size(), [&](std::size_t a, std::size_t b) {
      const std::uint32_t slot = slot_of_pair_[pair++];
      if (slots_[slot].count >= threshold_)
        candidates_.push_back({orderOf(slots_[slot]), slot, mixed(list[a], list[b]),
                               static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
    });
    next_pair_ = pair;
    if (candidates_.empty() || (i >= lists_.rows && lists_.list(i).size() == 2)) return;
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.order != b.order ? a.order > b.order : a.tie < b.tie;
    });
    taken_.assign(list.size(), 0);
    for (const Candidate& candidate : candidates_) {
      if (taken_[candidate.first] != 0 || taken_[candidate.second] != 0) continue;
      taken_[candidate.first] = taken_[candidate.second] = 1;
      chosen_.push_back({i, candidate.slot});
      ++slots_[candidate.slot].taken;
    }
  }

  void replace() {
    std::unordered_map<std::uint64_t, Symbol> known;
    for (std::size_t sum = 0; sum < lists_.sumCount(); ++sum)
      known.emplace(lists_.hashes[lists_.leaves + sum], static_cast<Symbol>(lists_.leaves + sum));
    const std::uint32_t least = std::max<std::uint32_t>(2, threshold_ - threshold_ / 4);
    SymbolLists next;
    next.leaves = lists_.leaves, next.rows = lists_.rows;
    next.hashes = std::move(lists_.hashes);
    next.begins.reserve(lists_.begins.size());
    next.symbols.reserve(lists_.symbols.size());
    std::vector<std::array<Symbol, 2>> made;
    auto chosen = chosen_.begin();
    for (std::uint32_t i = 0; i < lists_.listCount(); ++i) {
      const auto list = lists_.list(i);
      const std::size_t begin = next.symbols.size();
      next.symbols.insert(next.symbols.end(), list.begin(), list.end());
      for (; chosen != chosen_.end() && chosen->list == i; ++chosen) {
        PairSlot& slot = slots_[chosen->slot];
        if (slot.sum == ~Symbol{0}) {
          const std::uint64_t hash = next.hashes[slot.first] + next.hashes[slot.second];
          const auto found = known.find(hash);
          if (found != known.end()) {
            slot.sum = found->second;
          } else {
            if (slot.taken < least || next.hashes.size() >= most_symbols_) continue;
            slot.sum = static_cast<Symbol>(next.hashes.size());
            known.emplace(hash, slot.sum);
            next.hashes.push_back(hash);
            made.push_back({slot.first, slot.second});
          }
        }
        replaceIn({next.symbols.data() + begin, next.symbols.data() + next.symbols.size()}, slot);
      }
      next.symbols.erase(
          std::remove(next.symbols.begin() + static_cast<std::ptrdiff_t>(begin), next.symbols.end(), kGone),
          next.symbols.end());
      std::sort(next.symbols.begin() + static_cast<std::ptrdiff_t>(begin), next.symbols.end());
      next.begins.push_back(static_cast<std::uint32_t>(next.symbols.size()));
    }
    for (const auto& parts : made) {
      next.symbols.insert(next.symbols.end(), parts.begin(), parts.end());
      next.begins.push_back(static_cast<std::uint32_t>(next.symbols.size()));
    }
    lists_ = std::move(next);
  }

  static void replaceIn(std::span<Symbol> list, const PairSlot& slot) {
    *std::find(list.begin(), list.end(), slot.first) = slot.sum;
    *std::find(list.begin(), list.end(), slot.second) = kGone;
  }

  static constexpr Symbol kGone = ~Symbol{0};

  SymbolLists& lists_;
  std::uint32_t threshold_;
  std::size_t most_symbols_;
  std::vector<std::uint32_t> frequencies_;  // of each symbol: lists with it
  std::vector<Symbol> frequent_;
  mutable std::vector<PairSlot> slots_;
  std::vector<std::uint32_t> slot_of_pair_;
  std::size_t next_pair_ = 0;
  std::vector<Candidate> candidates_;
  std::vector<std::uint8_t> taken_;
  std::vector<Chosen> chosen_;
};

}  // namespace

void pairUp(SymbolLists& lists, std::uint32_t threshold, std::size_t most_symbols) {
  Round(lists, threshold, most_symbols).run();
}

}  // namespace bakelight::compression
