#include "transport/triple_product.h"
