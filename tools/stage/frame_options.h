// The parameters by which tools that make pictures of packs are told what to show.
#pragma once

#include <string>

#include "formats/frame_settings.h"
#include "tools/stage/stage.h"

namespace bakelight::stage {

// Camera, turned light and object, time and size of the picture: everything but exposure. Both references
// outlive the tool's run; `background` is the name, see finishedSettings.
void declareFrame(Tool& tool, formats::FrameSettings& settings, std::string& background);

// The settings with everything that is named by a word filled in.
formats::FrameSettings finishedSettings(const formats::FrameSettings& settings,
                                        const std::string& background);

}  // namespace bakelight::stage
