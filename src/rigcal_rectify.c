#include "rc_camera.h"
