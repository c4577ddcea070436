/* rc_paper.h - what the published procedure is made of. */
#ifndef RC_PAPER_H
#define RC_PAPER_H

#include "rc_camera.h"
#include "rc_equations.h"
#include "rc_neldermead.h"

#endif /* RC_PAPER_H */
