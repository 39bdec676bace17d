// What mouse and keys do to the picture, free of any window.
#pragma once

#include "transport/frame.h"

namespace bakelight::player {

// Printed at start and by --help.
inline constexpr const char* kControlsHelp =
    "left drag: orbit   right drag: turn the light   middle drag: turn the object   wheel: zoom   "
    "space: hold the emitters   R: reset   S: screenshot   Esc: quit";

// Dragging right moves the object's front to the right, dragging down tips its top towards the viewer:
// `dx_px` and `dy_px` as windows count, y down. Pitch stops at ±89°.
void dragOrbit(formats::FrameSettings& settings, double dx_px, double dy_px);
// Light from +Z follows the pointer.
void dragLight(formats::FrameSettings& settings, double dx_px, double dy_px);
// The object's front follows the pointer; camera and lights stay.
void dragObject(formats::FrameSettings& settings, double dx_px, double dy_px);
// Each step of the wheel away from the user comes 10% nearer; distance stays within 0.2–20.
void zoom(formats::FrameSettings& settings, double steps);

}  // namespace bakelight::player
