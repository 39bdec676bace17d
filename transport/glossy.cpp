#include "transport/glossy.h"
