// Transfer of a surface that nothing shadows: closed forms (NUMERICS.md).
#pragma once

#include "tools/stage/progress.h"
#include "tools/transfer/bake_setup.h"

namespace bakelight::transfer {

Transfer bakeUnshadowed(const BakeSetup& setup, stage::Progress& progress);

}  // namespace bakelight::transfer
