// How far a flat chart is from the surface.
#pragma once

#include <span>

#include "tools/atlas/charts/chart.h"
#include "transport/texture_stretch.h"

namespace bakelight::atlas {

using transport::crossOf;
using transport::Singular;
using transport::singularValues;
using transport::StretchSum;

StretchSum stretchOf(const Chart& chart, std::span<const Vec2> plane);

// Scales a chart such that its share in the L² stretch of an atlas is least: plane area = Σ area · (Γ² +
// γ²)/2.
void scaleForLeastStretch(const Chart& chart, std::span<Vec2> plane);

}  // namespace bakelight::atlas
