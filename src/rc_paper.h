/* rc_paper.h - what layers below use of the published procedure. */
#ifndef RC_PAPER_H
#define RC_PAPER_H

#include "rc_camera.h"
#include "rc_equations.h"
#include "rc_neldermead.h"

#endif /* RC_PAPER_H */
