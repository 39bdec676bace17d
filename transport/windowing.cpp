#include "transport/windowing.h"
