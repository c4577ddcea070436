/* rc_store.h - calibrations as bytes; see rigcal.h. The lowest layer. */
#ifndef RC_STORE_H
#define RC_STORE_H

#include "rc_camera.h"

/* CRC-32 of IEEE 802.3 (reflected polynomial EDB88320, all ones before, inverted
 * after), that of zlib, zip and PNG. */
uint32_t rc_crc32(const uint8_t bytes[], size_t n);

#endif /* RC_STORE_H */
