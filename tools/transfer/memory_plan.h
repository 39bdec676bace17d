// How a bake with bounces keeps within its memory: how it holds what points see, and how many fields it
// solves at once.
#pragma once

#include <cstddef>

#include "transport/form_factors.h"

namespace bakelight::transfer {

struct BakeSetup;

struct MemoryPlan {
  std::size_t limit = 0;  // bytes of the whole bake, without matrices
  transport::ShareStorage shares;
  std::size_t expected = 0;  // bytes at the peak; more than the limit where nothing smaller is possible
};

// Bytes that a bake may take unless it is told: 2 GB, or as much for each million vertices.
std::size_t defaultMemory(std::size_t vertices);

// Which storage fits is found out by what some points, evenly spread, see: exact shares if they do, else 16
// bits, else 16 bits with small shares put together as far as needed. Depends on nothing but the setup, so
// that all ranges of a bake agree. Cost: at most a hundredth of the rays, where it is not clear from the
// number of directions that exact shares fit.
MemoryPlan planMemory(const BakeSetup& setup);

inline constexpr std::size_t kLeastFields = 3;  // that a solution needs
std::size_t fieldBytes(std::size_t points, std::size_t columns);
// What is left for fields in the limit, shares taking `share_bytes`.
std::size_t roomForFields(const BakeSetup& setup, std::size_t points, std::size_t share_bytes);

}  // namespace bakelight::transfer
