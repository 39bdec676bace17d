// The last few results of something slow, by key.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <string>
#include <utility>

namespace bakelight::report {

template <class Value>
class RecentlyUsed {
 public:
  explicit RecentlyUsed(std::size_t capacity) : capacity_(capacity) {}

  // What is forgotten lives on while somebody holds it.
  std::shared_ptr<const Value> get(const std::string& key, const std::function<Value()>& make) {
    for (auto entry = entries_.begin(); entry != entries_.end(); ++entry)
      if (entry->first == key) {
        entries_.splice(entries_.begin(), entries_, entry);
        return entries_.front().second;
      }
    entries_.emplace_front(key, std::make_shared<const Value>(make()));
    if (entries_.size() > capacity_) entries_.pop_back();
    return entries_.front().second;
  }

 private:
  std::size_t capacity_;
  std::list<std::pair<std::string, std::shared_ptr<const Value>>> entries_;  // latest first
};

}  // namespace bakelight::report
