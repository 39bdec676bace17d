// A picture of a lit ball, made by code: glazed clay under a warm window and a cool sky.
#pragma once

#include "formats/pack_image.h"

namespace bakelight::example {

formats::PackImage madeBallPicture(int edge, formats::Precision precision);

}  // namespace bakelight::example
