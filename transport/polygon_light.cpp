#include "transport/lights.h"
