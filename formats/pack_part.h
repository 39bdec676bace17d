// Parts of a pack that differ by technique (its transfer, the reflection of its materials): a struct behind
// its name and its list of fields. Kinds of parts are an open list: a technique adds its own.
#pragma once

#include <concepts>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "formats/fields.h"

namespace bakelight::formats {

// Plain data that names itself and each of its fields once.
template <class T>
concept PackPartData = std::copyable<T> && requires(T value, FieldVisitor& fields) {
  { T::kKind } -> std::convertible_to<const char*>;
  value.describe(fields);
};

// Any PackPartData, by value.
class PackPart {
 public:
  template <class T>
  requires(!std::same_as<T, PackPart> && PackPartData<T>)  // in this order: a part is no data of a part
      PackPart(T value)
      : data_(std::make_unique<Holder<T>>(std::move(value))) {}
  PackPart(const PackPart& other) : data_(other.data_->clone()) {}
  PackPart(PackPart&&) noexcept = default;
  PackPart& operator=(const PackPart& other) { return *this = PackPart(other); }
  PackPart& operator=(PackPart&&) noexcept = default;
  ~PackPart() = default;

  const char* kind() const { return data_->kind(); }
  void describe(FieldVisitor& fields) { data_->describe(fields); }

  // Null if it is of another kind.
  template <PackPartData T>
  T* as() {
    auto* holder = dynamic_cast<Holder<T>*>(data_.get());
    return holder == nullptr ? nullptr : &holder->value;
  }
  template <PackPartData T>
  const T* as() const {
    return const_cast<PackPart*>(this)->as<T>();
  }

 private:
  struct Data {
    virtual ~Data() = default;
    virtual std::unique_ptr<Data> clone() const = 0;
    virtual const char* kind() const = 0;
    virtual void describe(FieldVisitor& fields) = 0;
  };
  template <PackPartData T>
  struct Holder final : Data {
    explicit Holder(T held) : value(std::move(held)) {}
    std::unique_ptr<Data> clone() const override { return std::make_unique<Holder>(value); }
    const char* kind() const override { return T::kKind; }
    void describe(FieldVisitor& fields) override { value.describe(fields); }
    T value;
  };

  std::unique_ptr<Data> data_;  // never null but after a move
};

// A kind that packs may hold, for their reader.
struct PackPartKind {
  const char* name;
  PackPart (*make)();

  template <PackPartData T>
  static PackPartKind of() {
    return {T::kKind, [] { return PackPart(T()); }};
  }
};
using PackPartKinds = std::vector<PackPartKind>;

// "lambert, phong, ggx or table", for messages.
std::string namesOf(const PackPartKinds& kinds);

}  // namespace bakelight::formats
