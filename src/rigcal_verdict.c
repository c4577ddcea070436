#include "rc_real.h"
