#include "formats/encoded_table.h"
