#include "transport/light_rig.h"
