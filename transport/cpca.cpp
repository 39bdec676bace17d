#include "transport/cpca.h"
