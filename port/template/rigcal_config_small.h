/* rigcal_config_small.h - all that may be left out is, for a small flash. What that
 * means is in include/rigcal_config.h, and how much it saves in port/qemu/README.md.
 *
 *     -DRIGCAL_CONFIG_FILE='"rigcal_config_small.h"'
 */
#ifndef RIGCAL_CONFIG_SMALL_H
#define RIGCAL_CONFIG_SMALL_H

#define RIGCAL_WITH_FISHEYE 0
#define RIGCAL_WITH_THREE_POINTS 0
#define RIGCAL_WITH_MIRRORED 0

#endif /* RIGCAL_CONFIG_SMALL_H */
