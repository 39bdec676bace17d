// Run-time evaluation on the CPU: what the player's shaders compute, for tests, reports and engines without a
// GPU.
#pragma once

#include <span>
#include <vector>

#include "transport/lights.h"

namespace bakelight::transport {

// Exit radiance of each vertex, albedo left out: Σ_i vectors[v·order² + i] · light[i] (Sloan et al. 2002, eq.
// 8). `vectors` is n × (channels · order²), with one channel for all colours or three, one for each; `light`
// has at least order² entries (further bands are ignored). Cost: n · order² · 3 multiply-adds, on all TBB
// threads.
std::vector<Float3> evaluateDiffuse(std::span<const float> vectors, int order, std::span<const Float3> light,
                                    int channels = 1);

}  // namespace bakelight::transport
