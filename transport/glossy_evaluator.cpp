#include "transport/glossy_evaluator.h"
