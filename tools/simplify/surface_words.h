// The room speaks in the words of surface/, which it works on throughout.
#pragma once

namespace bakelight::surface {}
namespace bakelight::simplify {
using namespace bakelight::surface;  // NOLINT(google-build-using-namespace)
}
