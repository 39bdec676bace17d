#include "formats/light_rig_file.h"
