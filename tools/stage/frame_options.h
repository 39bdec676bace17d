// The parameters by which tools that make pictures of packs are told what to show.
#pragma once

#include "formats/frame_settings.h"
#include "tools/stage/stage.h"

namespace bakelight::stage {

// Camera, turned light and object, time and size of the picture: everything but exposure. `settings` must
// outlive the tool's run.
void declareFrame(Tool& tool, formats::FrameSettings& settings);

}  // namespace bakelight::stage
