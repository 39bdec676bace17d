// The interactive player.
#pragma once

#include "formats/pack.h"
#include "tools/player/surroundings/surroundings.h"
#include "transport/frame.h"
#include "transport/lighting.h"

namespace bakelight::player {

// Opens a window of the settings' size and plays until it is closed; moving emitters move in real time, from
// the settings' time on. Throws Error(kNotAvailable) if there is
// no display or no OpenGL 4.5. Screenshots go to the working directory as <pack name>-<number>.png and never
// overwrite a file.
void playInWindow(const formats::Pack& pack, const transport::Lighting& lighting,
                  const formats::FrameSettings& settings, const SurroundingsOptions& surroundings = {});

}  // namespace bakelight::player
