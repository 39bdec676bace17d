// What this machine can do at best: read a buffer, and multiply and add, on all TBB threads with the widest
// vector instructions (those that transport/glossy_kernels.cpp uses, too).
#pragma once

#include <span>

namespace bakelight {

// The sum of a buffer aligned to 64 bytes, a multiple of 64 floats long, in chunks that TBB deals out.
double readSum(std::span<const float> buffer);

// Runs independent chains of multiply-adds, `steps` of each chain on each thread; returns how many scalar
// multiply-adds that were. `sink` keeps the result alive.
double multiplyAddChains(std::size_t steps, float& sink);

// The name of the instruction set.
const char* instructionSet();

}  // namespace bakelight
